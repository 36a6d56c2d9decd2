#include "core/view/clip_frames.h"

#include <utility>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
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
