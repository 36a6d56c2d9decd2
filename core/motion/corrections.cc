#include "core/motion/corrections.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/motion/error.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kMaxBend = 20 * kDegree;        // of elbows and knees
constexpr double kMaxAsymmetry = 12 * kDegree;   // between the arms
constexpr double kMaxOutOfPlane = 25 * kDegree;  // of an arm
constexpr double kMaxThighTilt = 25 * kDegree;   // from the trunk's line
constexpr double kLowestArm = 35 * kDegree;      // from the trunk
constexpr double kLevelArm = 75 * kDegree;
constexpr double kHighestArm = 108 * kDegree;
constexpr double kMaxMovement = 0.03;  // leg lengths, of a joint in the body's frame
constexpr double kJump = 0.12;         // leg lengths between two frames
constexpr double kJumpSpeed = 6;       // leg lengths per second
constexpr double kMinHeldSeconds = 0.25;
constexpr double kFilter_s = 0.15;
constexpr double kFilteredSpeed = 2;  // leg lengths per second

enum LimbJoint { kShoulder, kElbow, kWrist, kHip, kKnee, kAnkle, kJointCount };
constexpr const char* kJointNames[] = {"Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle"};
using Limbs = std::array<std::array<Eigen::Vector3d, kJointCount>, 2>;  // [left, right]

std::optional<std::array<std::array<int, kJointCount>, 2>> JointsOf(const MarkerSet& set) {
  std::array<std::array<int, kJointCount>, 2> joints{};
  for (int side = 0; side < 2; ++side) {
    for (int j = 0; j < kJointCount; ++j) {
      joints[side][j] = set.FindMarker(std::string(side == 0 ? "L" : "R") + kJointNames[j]);
      if (joints[side][j] < 0) return std::nullopt;
    }
  }
  return joints;
}

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

ReferencePose PoseOf(const Limbs& limbs) {
  const auto middle = [&](LimbJoint joint) -> Eigen::Vector3d {
    return (limbs[0][joint] + limbs[1][joint]) / 2;
  };
  const Eigen::Vector3d down = middle(kHip) - middle(kShoulder);
  const Eigen::Vector3d front = down.cross(limbs[1][kShoulder] - limbs[0][kShoulder]).normalized();
  std::array<double, 2> elevation{};
  for (int side = 0; side < 2; ++side) {
    const auto& limb = limbs[side];
    const Eigen::Vector3d upper_arm = limb[kElbow] - limb[kShoulder];
    const Eigen::Vector3d thigh = limb[kKnee] - limb[kHip];
    const Eigen::Vector3d arm = limb[kWrist] - limb[kShoulder];
    const bool straight = Angle(upper_arm, limb[kWrist] - limb[kElbow]) < kMaxBend &&
                          Angle(thigh, limb[kAnkle] - limb[kKnee]) < kMaxBend;
    const bool in_plane = std::abs(arm.normalized().dot(front)) < std::sin(kMaxOutOfPlane);
    if (!straight || !in_plane || !(Angle(thigh, down) < kMaxThighTilt)) {
      return ReferencePose::kNone;
    }
    // Outwards, not across the body.
    const Eigen::Vector3d outwards = limb[kShoulder] - limbs[1 - side][kShoulder];
    if (!(arm.dot(outwards) > 0)) return ReferencePose::kNone;
    elevation[side] = Angle(arm, down);
  }
  if (std::abs(elevation[0] - elevation[1]) > kMaxAsymmetry) return ReferencePose::kNone;
  const double mean = (elevation[0] + elevation[1]) / 2;
  if (mean < kLowestArm || mean > kHighestArm) return ReferencePose::kNone;
  return mean < kLevelArm ? ReferencePose::kA : ReferencePose::kT;
}

// Returns the joints relative to the hips, turned so that the hips' line is the y axis.
Limbs InBody(Limbs limbs) {
  const Eigen::Vector3d hips = (limbs[0][kHip] + limbs[1][kHip]) / 2;
  const Eigen::Vector3d lateral = limbs[0][kHip] - limbs[1][kHip];
  const double turn = std::atan2(lateral.x(), lateral.y());
  const Eigen::AngleAxisd body_from_world(turn, Eigen::Vector3d::UnitZ());
  for (auto& limb : limbs) {
    for (Eigen::Vector3d& joint : limb) joint = body_from_world * (joint - hips);
  }
  return limbs;
}

// Returns the largest movement of a joint in the body's frame.
double Movement(const Limbs& from, const Limbs& to) {
  double largest = 0;
  for (int side = 0; side < 2; ++side) {
    for (int j = 0; j < kJointCount; ++j) {
      largest = std::max(largest, (to[side][j] - from[side][j]).norm());
    }
  }
  return largest;
}

}  // namespace

PoseAtStart FindPoseAtStart(const MarkerSet& set, const MarkerMotion& motion, double leg_length_m) {
  const auto joints = JointsOf(set);
  const auto frames = static_cast<int>(motion.positions_m.rows());
  if (!joints || frames == 0) return {};
  const auto limbs_at = [&](int frame) {
    Limbs limbs;
    for (int side = 0; side < 2; ++side) {
      for (int j = 0; j < kJointCount; ++j) {
        limbs[side][j] =
            motion.positions_m.row(frame).segment<3>(3 * (*joints)[side][j]).cast<double>();
      }
    }
    return InBody(limbs);
  };
  const Limbs first = limbs_at(0);
  const ReferencePose pose = PoseOf(first);
  if (pose == ReferencePose::kNone) return {};
  int end = 1;
  while (end < frames && Movement(first, limbs_at(end)) < kMaxMovement * leg_length_m) ++end;
  if (end == frames) return {};
  // Distance (m) from the frame before.
  const auto step = [&](int frame) { return Movement(limbs_at(frame - 1), limbs_at(frame)); };
  const double speed_to_step = leg_length_m / motion.frame_rate_hz;
  const bool jumps = step(end) > std::max(kJump * leg_length_m, kJumpSpeed * speed_to_step);
  const bool is_held = end >= kMinHeldSeconds * motion.frame_rate_hz;
  if (!jumps && !is_held) return {};
  // Filters spread a jump over some frames.
  const int last = std::min(frames - 1, end + static_cast<int>(kFilter_s * motion.frame_rate_hz));
  if (jumps) {
    while (end < last && step(end + 1) > kFilteredSpeed * speed_to_step) ++end;
  }
  return {pose, end};
}

void ReplacePoseAtStart(const MarkerSet& set, double leg_length_m, MarkerMotion& motion) {
  const int count = FindPoseAtStart(set, motion, leg_length_m).frame_count;
  if (count == 0) return;
  motion.positions_m.topRows(count).rowwise() = motion.positions_m.row(count).eval();
}

namespace {

constexpr DerivedMarker kDerived[] = {
    {"LToe", "LAnkle", 0.14, -0.07},   {"RToe", "RAnkle", 0.14, -0.07},
    {"LHeel", "LAnkle", -0.05, -0.06}, {"RHeel", "RAnkle", -0.05, -0.06},
    {"Head", "Neck", 0.02, 0.22},      {"HeadTop", "Neck", 0.03, 0.33},
};

}  // namespace

std::span<const DerivedMarker> DerivedMarkers() { return kDerived; }

absl::Status AddDerivedMarkers(const MarkerSet& set, double leg_length_m, MarkerMotion& motion,
                               std::vector<std::string>& notes) {
  const auto is_missing = [&](int marker) {
    return marker >= 0 && motion.positions_m.middleCols<3>(3 * marker).array().isNaN().all();
  };
  std::string names;
  RootPath path;
  for (const auto& [name, from, front, up] : kDerived) {
    const int marker = set.FindMarker(name);
    const int base = set.FindMarker(from);
    if (base < 0 || !is_missing(marker) || is_missing(base)) continue;
    if (path.rows() == 0) {
      MOTIONDB_ASSIGN_OR_RETURN(path, ReferenceFrames(set, motion));
    }
    for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
      const double heading = path(t, 2);
      const Eigen::Vector3d offset(std::cos(heading) * front, std::sin(heading) * front, up);
      motion.positions_m.row(t).segment<3>(3 * marker) =
          motion.positions_m.row(t).segment<3>(3 * base) +
          (leg_length_m * offset).transpose().cast<float>();
    }
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  if (!names.empty()) notes.push_back("derived from the proportions of a person: " + names);
  return absl::OkStatus();
}

}  // namespace motiondb::core
