// The messages of Observe. INVALID_ARGUMENT and OUT_OF_RANGE name the field. Safe to call from any
// thread.
#pragma once

#include "absl/status/statusor.h"
#include "server/engine/observe_session.h"

namespace motiondb::v1 {
class MarkerObservation;
class ObservedFrames;
class ObserveResponse;
class ObserveStart;
}  // namespace motiondb::v1

namespace motiondb::server {

// `set`: the database's markers, for a start that names none.
absl::StatusOr<ObserveSetup> SetupFrom(const v1::ObserveStart& start, const core::Model& model,
                                       const core::MarkerSet& set);

// frames x 3 markers.
absl::StatusOr<core::FrameMatrix> FramesFrom(const v1::ObservedFrames& frames,
                                             const std::vector<std::string>& marker_names);

// `top_count` labels; 0 means all.
void SetStep(const ObserveStep& step, int top_count, v1::ObserveResponse& message);

void SetMarkers(const core::MarkerMotion& motion, v1::MarkerObservation& message);

}  // namespace motiondb::server
