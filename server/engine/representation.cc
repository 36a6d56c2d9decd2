#include "server/engine/representation.h"

#include <algorithm>
#include <variant>

#include "core/format/plausibility.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"

namespace motiondb::server {
namespace {

// Maximum frames x joints: about three seconds of forward kinematics; 268 joints for 250,000
// frames.
constexpr double kMaxPlacings = 1 << 26;
// Number of markers that max_frames is meant for: more markers need more memory and time for each
// frame.
constexpr double kUsualMarkers = 34;
// Maximum frames x markers or joints of light work: 30 s of 34 markers at 60 Hz. Recognition takes
// 0.1 s with few windows, some seconds with a window at each frame.
constexpr double kMaxLightPoints = 1 << 16;

absl::Status TooLong(const std::string& problem) {
  return core::WithReason("MOTION_TOO_LONG", absl::ResourceExhaustedError(
                                                 "the motion " + problem +
                                                 " (--max-frames): split it into shorter parts"));
}

double FrameCount(const core::Motion& motion) {
  if (const auto* joints = std::get_if<core::JointMotion>(&motion)) {
    return static_cast<double>(joints->angles.rows());
  }
  return static_cast<double>(std::get<core::MarkerMotion>(motion).positions_m.rows());
}

// Memory for the motion, the database's markers at the motion's rate (with link offsets in double
// precision) and at the database's rate, their states, and temporary data for sizes and gaps.
std::int64_t BytesToRepresent(const core::Motion& motion, std::int64_t frames, int marker_count) {
  constexpr std::int64_t kMeasures = 64;  // a frame
  const auto own_frames = static_cast<std::int64_t>(FrameCount(motion));
  const std::int64_t mapped = own_frames * marker_count * 12;
  if (const auto* joints = std::get_if<core::JointMotion>(&motion)) {
    const std::int64_t offsets = 2 * mapped;
    const std::int64_t later =
        frames * (kMeasures + marker_count * 12) + BytesOfStates(frames, marker_count);
    return joints->angles.size() * 8 + mapped + std::max(offsets, later);
  }
  return std::get<core::MarkerMotion>(motion).positions_m.size() * 4 + mapped +
         frames * (kMeasures + marker_count * 12) + BytesOfStates(frames, marker_count);
}

}  // namespace

std::int64_t BytesOfStates(std::int64_t frames, int marker_count) {
  return frames * (marker_count * 24 + 24);
}

double FrameRate(const core::Motion& motion) {
  return std::visit([](const auto& form) { return form.frame_rate_hz; }, motion);
}

absl::Status CheckSize(const RepresentationLimits& limits, int marker_count,
                       const core::Motion& motion) {
  const double own_frames = FrameCount(motion);
  MOTIONDB_RETURN_IF_ERROR(core::CheckFrameRate(FrameRate(motion), limits.frame_rate_hz));
  if (own_frames > limits.max_frames) {
    return TooLong(fmt::format("has {} frames, the limit is {}", own_frames, limits.max_frames));
  }
  const double seconds = own_frames / FrameRate(motion);
  const double frames = std::max(own_frames, seconds * limits.frame_rate_hz);
  if (!(frames <= limits.max_frames)) {
    return TooLong(
        fmt::format("has {} frames at {:g} Hz, {:g} s; the limit at the database's {:g} Hz is {} "
                    "frames, {:g} s",
                    own_frames, FrameRate(motion), seconds, limits.frame_rate_hz, limits.max_frames,
                    limits.max_frames / limits.frame_rate_hz));
  }
  const double points = frames * marker_count;
  if (points > limits.max_frames * kUsualMarkers) {
    return TooLong(fmt::format("has {:.0f} frames, the limit for {} markers is {:.0f}", frames,
                               marker_count, limits.max_frames * kUsualMarkers / marker_count));
  }
  const auto* const joints = std::get_if<core::JointMotion>(&motion);
  const double placings = joints == nullptr ? 0 : own_frames * joints->skeleton->joint_count();
  if (placings > kMaxPlacings) {
    return core::InvalidArgument(
        "the motion has {} frames of {} joints, the limit is 2^26 frames x joints: shorten it",
        own_frames, joints->skeleton->joint_count());
  }
  const bool light = std::max(points, placings) <= kMaxLightPoints;
  if (!light && limits.terms.allowed == AllowedWork::kLightWork) return HeavyWork();
  return limits.terms.Reserve(
      BytesToRepresent(motion, static_cast<std::int64_t>(frames) + 1, marker_count));
}

absl::StatusOr<core::StateSequence> RepresentWithin(
    const RepresentationLimits& limits, const core::MarkerScheme& scheme,
    const core::Motion& motion, core::Cleaning cleaning, std::optional<double> leg_length_m,
    std::vector<std::string>* notes, core::SourcePart* part) {
  MOTIONDB_RETURN_IF_ERROR(CheckSize(limits, scheme.set.marker_count(), motion));
  std::string note;
  MOTIONDB_ASSIGN_OR_RETURN(
      const core::MarkerScheme fitted,
      core::FitScheme(scheme, motion, cleaning ? core::FitFor::kClip : core::FitFor::kQuery,
                      &note));
  if (notes != nullptr && !note.empty()) notes->push_back(note);
  return core::Represent(fitted, motion, limits.frame_rate_hz, cleaning, leg_length_m, notes,
                         limits.terms.cancelled, part);
}

}  // namespace motiondb::server
