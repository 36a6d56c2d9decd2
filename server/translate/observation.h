// An observation of a request -> the engine's. Safe to call from any thread.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/engine/observation.h"
#include "server/engine/observe_session.h"

namespace motiondb::v1 {
class MarkerObservation;
class Observation;
class ObserveResponse;
class ObserveStart;
class ObservedFrames;
}  // namespace motiondb::v1

namespace motiondb::server {

// Refers to `message`. `field` is the observation's own name in the request, and leads the names of
// fields in errors; `database` the id of the one that is asked. INVALID_ARGUMENT.
absl::StatusOr<Observation> ObservationFrom(std::string_view field, const v1::Observation& message,
                                            const std::string& database);

// The messages of Observe. Safe to call from any thread.

absl::StatusOr<ObserveSetup> SetupFrom(const v1::ObserveStart& start);

// Refers to the message.
PackedFrames FramesFrom(const v1::ObservedFrames& frames);

// `top_count` labels; 0 means all.
void SetStep(const ObserveStep& step, int top_count, v1::ObserveResponse& message);

void SetMarkers(const core::MarkerMotion& motion, v1::MarkerObservation& message);

}  // namespace motiondb::server
