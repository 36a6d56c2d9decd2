// Converts observations and the messages of Observe.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/engine/query/observation.h"
#include "server/engine/query/observe_session.h"

namespace motiondb::v1 {
class MarkerObservation;
class Observation;
class ObserveResponse;
class ObserveStart;
class ObservedFrames;
}  // namespace motiondb::v1

namespace motiondb::server {

// Converts an observation; the result refers to `message`. `field` is the path of the observation
// in the request, for errors; `database` is the id of the database. Returns INVALID_ARGUMENT for an
// invalid field.
absl::StatusOr<Observation> ParseObservation(std::string_view field, const v1::Observation& message,
                                             const std::string& database);

absl::StatusOr<ObserveSetup> ParseObserveSetup(const v1::ObserveStart& start);

// The result refers to `frames`.
PackedFrames FramesFrom(const v1::ObservedFrames& frames);

// Sets at most `top_count` labels; 0 means all.
void SetStep(const ObserveStep& step, int top_count, v1::ObserveResponse& message);

void SetMarkers(const core::MarkerMotion& motion, v1::MarkerObservation& message);

}  // namespace motiondb::server
