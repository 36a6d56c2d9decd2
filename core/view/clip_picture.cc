#include "core/view/clip_picture.h"

#include <algorithm>
#include <utility>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr int kBoneFrames = 256;  // of a motion

}  // namespace

std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const DistanceSpread& spread) {
  const Eigen::MatrixXd costs =
      spread.Variances().cwiseMax(0).cwiseSqrt() + kLengthCost * spread.Means();
  std::vector<BoneEnds> bones;
  for (const auto& [marker, parent] : SpanningTree(costs, std::max(0, set.landmarks.left_hip))) {
    if (parent >= 0) bones.emplace_back(parent, marker);
  }
  return bones;
}

std::vector<BoneEnds> MarkerBones(const Model& model) {
  return MarkerBones(model.marker_set(), SpreadOfClips(model.parts()));
}

std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const StateSequence& states) {
  DistanceSpread spread(set.marker_count());
  spread.Add(states.states(SpreadEvenly(states.frame_count(), kBoneFrames), Eigen::all));
  return MarkerBones(set, spread);
}

std::vector<BoneEnds> MarkerBonesOf(const MarkerSet& set, const Skeleton& skeleton) {
  std::vector<int> marker_of_joint(skeleton.joint_count(), -1);
  for (int m = 0; m < set.marker_count(); ++m) {
    const int joint = skeleton.FindJoint(set.markers[m]);
    if (joint < 0) return {};
    marker_of_joint[joint] = m;
  }
  std::vector<BoneEnds> bones;
  std::vector<int> nearest(skeleton.joint_count(), -1);  // marker of the joint or an ancestor
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.joints()[joint].parent;
    const int above = parent < 0 ? -1 : nearest[parent];
    const int marker = marker_of_joint[joint];
    nearest[joint] = marker < 0 ? above : marker;
    if (marker >= 0 && above >= 0) bones.emplace_back(above, marker);
  }
  return bones;
}

std::vector<BoneEnds> JointBones(const Skeleton& skeleton) {
  std::vector<BoneEnds> bones;
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.joints()[joint].parent;
    if (parent >= 0) bones.emplace_back(parent, joint);
  }
  return bones;
}

namespace {

JointMotion PartOf(const JointMotion& motion, const SourcePart& part) {
  return {motion.skeleton, motion.frame_rate_hz,
          motion.angles.middleRows(part.first_frame, part.frame_count)};
}

}  // namespace

absl::StatusOr<FrameMatrix> RecordedJoints(const JointMotion& motion, const SourcePart& part,
                                           double frame_rate_hz) {
  MarkerMotion joints{{}, motion.frame_rate_hz, JointPositions(PartOf(motion, part))};
  for (int joint = 0; joint < motion.skeleton->joint_count(); ++joint) {
    joints.positions_m.col(3 * joint + 2).array() -= static_cast<float>(part.floor_m);
  }
  MOTIONDB_ASSIGN_OR_RETURN(MarkerMotion resampled, Resample(joints, frame_rate_hz));
  return std::move(resampled.positions_m);
}

absl::StatusOr<FrameMatrix> RecordedRotations(const JointMotion& motion, const SourcePart& part,
                                              double frame_rate_hz) {
  // Quaternions are interpolated number by number, as positions are, and normalized. Neighbours are
  // at most 90 degrees apart (JointRotations), so that no sum of them is near 0.
  const MarkerMotion joints{{}, motion.frame_rate_hz, JointRotations(PartOf(motion, part))};
  MOTIONDB_ASSIGN_OR_RETURN(MarkerMotion resampled, Resample(joints, frame_rate_hz));
  FrameMatrix rotations = std::move(resampled.positions_m);
  for (Eigen::Index frame = 0; frame < rotations.rows(); ++frame) {
    for (Eigen::Index column = 0; column < rotations.cols(); column += 4) {
      rotations.block<1, 4>(frame, column).normalize();
    }
  }
  return rotations;
}

std::vector<std::uint8_t> StandingFeet(const MarkerSet& set, const Feet& feet,
                                       const FrameMatrix& positions_m, double frame_rate_hz,
                                       double leg_length_m) {
  if (feet.empty()) return {};
  const ContactMatrix contacts = DetectContacts(feet, positions_m, frame_rate_hz, leg_length_m);
  std::vector<std::uint8_t> standing(static_cast<std::size_t>(contacts.rows()), 0);
  Eigen::Index column = 0;
  for (const Foot& foot : feet) {
    const auto markers = static_cast<Eigen::Index>(foot.contact_markers.size());
    const std::uint8_t bit = foot.leg[0] == set.landmarks.left_hip ? kLeftFoot : kRightFoot;
    for (Eigen::Index t = 0; t < contacts.rows(); ++t) {
      if (contacts.row(t).segment(column, markers).any()) {
        standing[static_cast<std::size_t>(t)] |= bit;
      }
    }
    column += markers;
  }
  return standing;
}

}  // namespace motiondb::core
