// One motion from the stored frames of a path (section VI-E): blended at its joins, faded in from
// where it begins, on the body's soles, feet kept where they stand. Safe to call from any thread.
#pragma once

#include <vector>

#include "core/planning/body.h"
#include "core/planning/contacts.h"
#include "core/planning/splice.h"
#include "core/planning/start.h"

namespace motiondb::core {

struct SynthesisedMotion {
  MarkerMotion markers;    // m, on the plan's floor, at the model's frame rate
  ContactMatrix contacts;  // as the stored frames had them
};

// `root` has the reference frame of each played frame (see PlayedRoot), on the plan's floor.
SynthesisedMotion Synthesise(const Model& model, const Body& body, const PlanOrigin& origin,
                             const SplicedPath& path, const std::vector<FloorPose>& root);

// Positions (1 x 3 N_v) out of a state (1 x 6 N_v).
Eigen::RowVectorXf PositionsOf(const Eigen::Ref<const Eigen::RowVectorXf>& state);

// Marker positions (1 x 3 N_v) in a reference frame, in leg lengths, put where that frame is, in m.
Eigen::RowVectorXf OnFloor(const Eigen::Ref<const Eigen::RowVectorXf>& positions,
                           double leg_length_m, const FloorPose& root);

}  // namespace motiondb::core
