// Geometry for pictures of the frames of a clip: the joints of the recorded skeleton, in time with
// the stored states, and which feet stand on the floor. Also bones (lines between points), which
// are of a marker set, a model or a skeleton, and of no clip.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/marker_distances.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

class Model;

// Two points, as indices; the first is nearer to the root.
using BoneEnds = std::pair<int, int>;

// Returns the minimum spanning tree of the markers, from the left hip outward, by the standard
// deviation of their distances plus kLengthCost of the mean distance: of markers that all move
// together, neighbours are joined. O(markers^2).
inline constexpr double kLengthCost = 0.05;
std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const DistanceSpread& spread);

// The same, from a sample of the model's clips. O(markers^2).
std::vector<BoneEnds> MarkerBones(const Model& model);
// The same, from a sample of one motion that is in no model.
std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const StateSequence& states);

// Returns the bones of a marker set whose markers all are joints of the skeleton: each is joined to
// its nearest ancestor in the set. Empty if a marker is no joint. O(markers * joints).
std::vector<BoneEnds> MarkerBonesOf(const MarkerSet& set, const Skeleton& skeleton);

// Returns the bones of a skeleton: each joint but a root is joined to its parent.
std::vector<BoneEnds> JointBones(const Skeleton& skeleton);

// Returns the positions of all joints (frames x 3 * joint_count, m, world) by forward kinematics,
// at this frame rate, with the floor at z = 0. `part`: the frames of the states (Represent). Frame
// i is that of state i. Errors: those of Resample. REQUIRES: the motion has these frames. O(frames
// * joints).
absl::StatusOr<FrameMatrix> RecordedJoints(const JointMotion& motion, const SourcePart& part,
                                           double frame_rate_hz);

// Returns the rotations of all joints (JointRotations) in the frames of RecordedJoints. Errors and
// REQUIRES as there. O(frames * joints).
absl::StatusOr<FrameMatrix> RecordedRotations(const JointMotion& motion, const SourcePart& part,
                                              double frame_rate_hz);

inline constexpr std::uint8_t kLeftFoot = 1;
inline constexpr std::uint8_t kRightFoot = 2;

// Returns, for each frame, the feet (bits) of which a marker is in contact (DetectContacts). Empty
// if there are no feet. `positions_m`: frames x 3 N_v, world, floor at z = 0. O(frames * contact
// markers).
std::vector<std::uint8_t> StandingFeet(const MarkerSet& set, const Feet& feet,
                                       const FrameMatrix& positions_m, double frame_rate_hz,
                                       double leg_length_m);

}  // namespace motiondb::core
