#include "core/planning/motion_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/states.h"
#include "core/planning/plan.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {
namespace {

constexpr double kCentimetres = 100;

double FootSlide(const Feet& feet, const MarkerMotion& markers, const ContactMatrix& contacts) {
  const FrameMatrix& positions = markers.positions_m;
  double distance = 0;
  Eigen::Index steps = 0;
  Eigen::Index first_column = 0;
  for (const Foot& foot : feet) {
    for (Eigen::Index t = 0; t + 1 < positions.rows(); ++t) {
      float min_step = std::numeric_limits<float>::infinity();
      for (std::size_t i = 0; i < foot.contact_markers.size(); ++i) {
        const Eigen::Index column = first_column + static_cast<Eigen::Index>(i);
        if (!contacts(t, column) || !contacts(t + 1, column)) continue;
        const int at = 3 * foot.contact_markers[i];
        // A comparison with NaN is false.
        min_step = std::min(
            min_step,
            (positions.row(t + 1).segment<2>(at) - positions.row(t).segment<2>(at)).norm());
      }
      if (!std::isfinite(min_step)) continue;
      distance += min_step;
      ++steps;
    }
    first_column += static_cast<Eigen::Index>(foot.contact_markers.size());
  }
  return steps > 0 ? kCentimetres * distance * markers.frame_rate_hz / static_cast<double>(steps)
                   : 0;
}

double Penetration(const Feet& feet, const FrameMatrix& positions_m, double leg_length_m) {
  double deepest_m = 0;
  for (const Foot& foot : feet) {
    for (std::size_t i = 0; i < foot.contact_markers.size(); ++i) {
      const double rest_m = foot.rest_heights[i] * leg_length_m;
      for (const float height_m : positions_m.col(3 * foot.contact_markers[i] + 2)) {
        if (rest_m - height_m > deepest_m) deepest_m = rest_m - height_m;
      }
    }
  }
  return kCentimetres * deepest_m;
}

double ThirdDifference(double a, double b, double c, double d) { return d - 3 * c + 3 * b - a; }

double PeakMarkerJerk(const MarkerMotion& markers) {
  const FrameMatrix& p = markers.positions_m;
  double peak = 0;
  for (Eigen::Index t = 0; t + 3 < p.rows(); ++t) {
    double sum = 0;
    Eigen::Index count = 0;
    for (Eigen::Index c = 0; c < p.cols(); ++c) {
      const double jerk = ThirdDifference(p(t, c), p(t + 1, c), p(t + 2, c), p(t + 3, c));
      if (!std::isfinite(jerk)) continue;
      sum += jerk * jerk;
      ++count;
    }
    if (count > 0) peak = std::max(peak, std::sqrt(3 * sum / static_cast<double>(count)));
  }
  return peak * std::pow(markers.frame_rate_hz, 3);
}

// Rotation vectors (rad, in the joint's own frame) between successive frames.
std::vector<Eigen::Vector3d> Turns(const JointMotion& joints, int joint) {
  const Joint& description = joints.skeleton->joints()[joint];
  const int first = joints.skeleton->first_dof(joint);
  std::vector<Eigen::Vector3d> turns;
  Eigen::Matrix3d before;
  for (Eigen::Index t = 0; t < joints.angles.rows(); ++t) {
    const std::span<const double> q(joints.angles.row(t).data() + first, description.dofs.size());
    const Eigen::Matrix3d now = ParentFromJoint(description, q).linear();
    if (t > 0) {
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(before.transpose() * now));
      turns.push_back(turn.angle() * turn.axis());
    }
    before = now;
  }
  return turns;
}

void MeasureJoints(const JointMotion& joints, MotionQuality& quality) {
  double speed = 0;
  double jerk = 0;
  for (int j = 0; j < joints.skeleton->joint_count(); ++j) {
    if (joints.skeleton->joints()[j].dofs.empty()) continue;
    const std::vector<Eigen::Vector3d> turns = Turns(joints, j);
    for (std::size_t t = 0; t < turns.size(); ++t) {
      speed = std::max(speed, turns[t].norm());
      if (t + 2 < turns.size()) {
        jerk = std::max(jerk, (turns[t + 2] - 2 * turns[t + 1] + turns[t]).norm());
      }
    }
  }
  quality.peak_joint_speed_rad_s = speed * joints.frame_rate_hz;
  quality.peak_joint_jerk_rad_s3 = jerk * std::pow(joints.frame_rate_hz, 3);
}

}  // namespace

MotionQuality MeasureQuality(const Feet& feet, const MarkerMotion& markers,
                             const ContactMatrix& contacts, double leg_length_m,
                             const JointMotion* joints) {
  MotionQuality quality;
  quality.foot_slide_cm_per_s = FootSlide(feet, markers, contacts);
  quality.floor_penetration_cm = Penetration(feet, markers.positions_m, leg_length_m);
  quality.peak_marker_jerk_m_s3 = PeakMarkerJerk(markers);
  if (joints != nullptr) MeasureJoints(*joints, quality);
  return quality;
}

absl::Status MeasureExtrapolation(const Model& model, const MarkerSet& set,
                                  std::shared_ptr<const ClipMask> mask, double leg_length_m,
                                  const Cancelled& cancelled, PlannedMotion& motion) {
  if (!model.recognition().window.unknown || motion.markers.positions_m.rows() < 2) {
    return absl::OkStatus();
  }
  MOTIONDB_ASSIGN_OR_RETURN(const MarkerMotion resampled,
                            Resample(motion.markers, model.settings().frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(const StateSequence states,
                            ComputeStates(set, resampled, leg_length_m));
  RecognizeOptions options;
  options.mask = std::move(mask);
  MOTIONDB_ASSIGN_OR_RETURN(const auto windows, Recognize(model, states, options, cancelled));
  for (const RecognizedWindow& window : windows) {
    if (!window.unknown_probability) continue;
    if (motion.quality.unknown &&
        *window.unknown_probability <= motion.quality.unknown->probability) {
      continue;
    }
    motion.quality.unknown =
        UnlikeStored{*window.unknown_probability, (window.start_seconds + window.end_seconds) / 2};
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
