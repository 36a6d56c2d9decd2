// Synthesis of one motion from a path of stored frames: its start, blending, and playback on the
// body.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/body.h"
#include "core/planning/contacts.h"
#include "core/planning/plan.h"
#include "core/planning/splice.h"

namespace motiondb::core {

class Model;

// The stored frame from which a plan starts, and the state in which the motion begins, which fades
// into it.
struct PlanOrigin {
  int frame = 0;
  Eigen::RowVectorXf state;  // 1 x 6 N_v, in leg lengths, as in a StateSequence; NaN where missing
  double leg_length_m = 0;   // of the subject at the start
};

// Returns origins: for a moment of a clip, its own frame; for an observation, the frame most
// similar to its last one, by positions and velocities of all markers; for standing, the frame that
// moves least. Only playable frames, with half a second left if their range is
// that long; for another moment of a clip, the most similar such frame.
//
// NOT_FOUND for an unknown clip; OUT_OF_RANGE for a moment outside the clip; INVALID_ARGUMENT if no
// frame is playable or the observation does not fit the model. O(frames * dimensions).
//
// If the start is not a stored frame to be played itself, the best frames of other ranges follow,
// at most five in total, because some lead nowhere.
absl::StatusOr<std::vector<PlanOrigin>> FindOrigins(const Model& model, const PlanStart& start,
                                                    const Playable& playable);

// One motion from the stored frames of a path (section VI-E): blended at joins, faded in from the
// start state, on the body's soles, with standing feet kept in place.
struct SynthesisedMotion {
  MarkerMotion markers;    // m, on the plan's floor, at the model's frame rate
  ContactMatrix contacts;  // of the stored frames
};

// `root`: the reference frame of each played frame (see PlayedRoot), on the plan's floor.
SynthesisedMotion Synthesise(const Model& model, const Body& body, const PlanOrigin& origin,
                             const SplicedPath& path, const std::vector<FloorPose>& root);

// Extracts positions (1 x 3 N_v) from a state (1 x 6 N_v).
Eigen::RowVectorXf PositionsOf(const Eigen::Ref<const Eigen::RowVectorXf>& state);

// Transforms marker positions (1 x 3 N_v) from a reference frame, in leg lengths, to the floor, in
// m.
Eigen::RowVectorXf OnFloor(const Eigen::Ref<const Eigen::RowVectorXf>& positions,
                           double leg_length_m, const FloorPose& root);

// Retargets the motion to the body and measures it. Sets root, markers, joints, and the quality
// except the correction. The outcome is kExact or kApproximate, judged on the returned markers.
// INVALID_ARGUMENT if the body cannot play the motion; CANCELLED.
absl::Status RetargetToBody(const MarkerScheme& scheme, const Body& body,
                            const PlanProblem& problem, const SynthesisedMotion& motion,
                            const Cancelled& cancelled, PlannedMotion& planned);

}  // namespace motiondb::core
