// From a path of stored frames to one motion: where it begins, and how its runs become one.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/body.h"
#include "core/planning/contacts.h"
#include "core/planning/plan.h"
#include "core/planning/splice.h"

namespace motiondb::core {

// Where a plan begins among the stored frames. Safe to call from any thread.
class Model;

// A stored frame to go on from, and the state that the motion really begins in, which fades into
// it.
struct PlanOrigin {
  int frame = 0;
  Eigen::RowVectorXf state;  // 1 x 6 N_v, in leg lengths, as in a StateSequence; NaN where missing
  double leg_length_m = 0;   // of who begins
};

// For a moment of a clip that is its own frame; for an observation the frame most like its last
// one, by place and velocity of all markers; for standing the one that moves least. Only frames of
// clips with one of `labels` (empty: all) and with half a second to go, if their clip is that long:
// any other moment of a clip begins at the frame most like it.
//
// NOT_FOUND for a clip that the model does not have; OUT_OF_RANGE for a moment outside the clip;
// INVALID_ARGUMENT if no clip has such a label or the observation does not fit the model.
// O(frames * dimensions).
//
// After the best, the best of other clips follow, at most five in all, where the start is not a
// stored frame to be played itself: some lead nowhere.
absl::StatusOr<std::vector<PlanOrigin>> FindOrigins(const Model& model, const PlanStart& start,
                                                    const std::vector<std::string>& labels);

// One motion from the stored frames of a path (section VI-E): blended at its joins, faded in from
// where it begins, on the body's soles, feet kept where they stand; and as the body plays it. Safe
// to call from any thread.
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

// Fills in what follows from the motion alone: root, markers, joints, and of the quality all but
// the correction. The outcome is kExact or kApproximate, judged on the markers that are returned.
// INVALID_ARGUMENT if the body cannot play it; CANCELLED.
absl::Status Perform(const MarkerScheme& scheme, const Body& body, const PlanProblem& problem,
                     SynthesisedMotion motion, const Cancelled& cancelled, PlannedMotion& planned);

}  // namespace motiondb::core
