#include "server/engine/representation.h"

#include <variant>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

// Frames times joints: some ten seconds of forward kinematics. A million frames have 268 joints.
constexpr double kMostPlacings = 1 << 28;

double FrameCount(const core::Motion& motion) {
  if (const auto* joints = std::get_if<core::JointMotion>(&motion)) {
    return static_cast<double>(joints->angles.rows());
  }
  return static_cast<double>(std::get<core::MarkerMotion>(motion).positions_m.rows());
}

}  // namespace

double FrameRate(const core::Motion& motion) {
  return std::visit([](const auto& form) { return form.frame_rate_hz; }, motion);
}

absl::Status CheckFrameCount(const core::Motion& motion, int max_frames) {
  const double frames = FrameCount(motion);
  if (frames > max_frames) {
    return core::InvalidArgument("the motion has {} frames; at most {} are taken", frames,
                                 max_frames);
  }
  const auto* const joints = std::get_if<core::JointMotion>(&motion);
  if (joints != nullptr && frames * joints->skeleton->joint_count() > kMostPlacings) {
    return core::InvalidArgument("the motion has {} frames of {} joints, more than can be placed",
                                 frames, joints->skeleton->joint_count());
  }
  return absl::OkStatus();
}

absl::StatusOr<core::StateSequence> RepresentWithin(const RepresentationLimits& limits,
                                                    const core::MarkerScheme& scheme,
                                                    const core::Motion& motion, core::Gaps gaps,
                                                    std::optional<double> leg_length_m,
                                                    std::vector<std::string>* notes) {
  MOTIONDB_RETURN_IF_ERROR(CheckFrameCount(motion, limits.max_frames));
  const double seconds = FrameCount(motion) / FrameRate(motion);
  if (!(seconds * limits.frame_rate_hz <= limits.max_frames)) {
    return core::InvalidArgument(
        "the motion has {} frames at {:g} Hz, {:g} s; at the database's {:g} Hz at most {} frames "
        "({:g} s) are taken",
        FrameCount(motion), FrameRate(motion), seconds, limits.frame_rate_hz, limits.max_frames,
        limits.max_frames / limits.frame_rate_hz);
  }
  return core::Represent(scheme, motion, limits.frame_rate_hz, gaps, leg_length_m, notes);
}

}  // namespace motiondb::server
