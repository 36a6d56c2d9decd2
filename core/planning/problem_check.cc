#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/plan.h"

namespace motiondb::core {
namespace {

constexpr double kMaxGoal_m = 1000;
constexpr double kMaxHeading = 2 * std::numbers::pi;  // more is usually in degrees
constexpr double kMaxMotionSeconds = 120;
constexpr int kMaxAlternatives = 10;
constexpr double kMaxAcceleration = 1e6;  // rad/s^2 or m/s^2
// All motions of an answer together: ten alternatives of 120 s at 120 Hz are 158,400.
constexpr double kMaxFrames = 200'000;
constexpr std::size_t kShownLabels = 10;
constexpr std::size_t kMaxObstacles = 1000;
constexpr std::size_t kMaxCorners = 10'000;
constexpr std::size_t kMaxPolygonCorners = 2'000;  // of one polygon; checking is quadratic at worst
constexpr double kMaxObstacle_m = 10'000;

absl::Status CheckBetween(std::string_view field, double value, double minimum, double maximum) {
  if (value >= minimum && value <= maximum) return absl::OkStatus();
  return FieldViolation(field, "expected {} to {}, got {}", minimum, maximum, value);
}

absl::Status CheckPositive(std::string_view field, double value, double maximum) {
  if (value > 0 && value <= maximum) return absl::OkStatus();
  return FieldViolation(field, "expected above 0, at most {}, got {}", maximum, value);
}

absl::Status CheckNotNegative(std::string_view field, double value) {
  if (value >= 0 && std::isfinite(value)) return absl::OkStatus();
  return FieldViolation(field, "expected 0 or more, got {}", value);
}

absl::Status CheckGoal(const FloorPose& goal) {
  MOTIONDB_RETURN_IF_ERROR(CheckBetween("goal.x_m", goal.x, -kMaxGoal_m, kMaxGoal_m));
  MOTIONDB_RETURN_IF_ERROR(CheckBetween("goal.y_m", goal.y, -kMaxGoal_m, kMaxGoal_m));
  if (std::abs(goal.heading) <= kMaxHeading) return absl::OkStatus();
  return FieldViolation("goal.heading_rad",
                        "expected -2 pi to 2 pi radians, got {0}; {0} degrees are {1:.4g} radians",
                        goal.heading, goal.heading * std::numbers::pi / 180);
}

absl::Status CheckLabels(const Model& model, const Playable& playable) {
  const std::vector<std::string>& labels = playable.labels;
  const auto units = UnitsOf(model, playable.track);
  const std::vector<std::string>& known = units->labels();
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (std::ranges::binary_search(known, labels[i])) continue;
    const bool few = known.size() <= kShownLabels;
    return FieldViolation(
        fmt::format("labels[{}]", i), "unknown label '{}'; the model has {}", labels[i],
        few ? fmt::format("{}", fmt::join(known, ", ")) : fmt::format("{} labels", known.size()));
  }
  return absl::OkStatus();
}

absl::Status CheckPoint(const std::string& field, const Eigen::Vector2d& point) {
  MOTIONDB_RETURN_IF_ERROR(
      CheckBetween(field + ".x_m", point.x(), -kMaxObstacle_m, kMaxObstacle_m));
  return CheckBetween(field + ".y_m", point.y(), -kMaxObstacle_m, kMaxObstacle_m);
}

absl::Status CheckCorners(const std::string& field, const Polygon& polygon) {
  if (polygon.corners.size() > kMaxPolygonCorners) {
    return FieldViolation(field, "expected at most {}, got {}", kMaxPolygonCorners,
                          polygon.corners.size());
  }
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(CheckPoint(fmt::format("{}[{}]", field, i), polygon.corners[i]));
  }
  const absl::Status status = CheckPolygon(polygon);
  return status.ok() ? status : FieldViolation(field, std::string(status.message()));
}

absl::Status CheckFrames(const PlanProblem& problem, double model_rate_hz) {
  if (problem.frame_rate_hz) {
    MOTIONDB_RETURN_IF_ERROR(
        CheckBetween("frame_rate_hz", *problem.frame_rate_hz, kMinFrameRate_hz, kMaxFrameRate_hz));
  }
  const double rate = problem.frame_rate_hz.value_or(model_rate_hz);
  const int motions = 1 + problem.alternative_count;
  if (rate * problem.max_duration_seconds * motions <= kMaxFrames) return absl::OkStatus();
  return FieldViolation(
      "frame_rate_hz",
      "expected at most {} frames in total, got {} motions of up to {} s at {} Hz; reduce their "
      "number, duration or frame rate",
      kMaxFrames, motions, problem.max_duration_seconds, rate);
}

}  // namespace

absl::Status CheckObstacles(const Obstacles& obstacles) {
  const std::size_t count = obstacles.discs.size() + obstacles.polygons.size();
  if (count > kMaxObstacles) {
    return FieldViolation("obstacles", "expected at most {} obstacles, got {}", kMaxObstacles,
                          count);
  }
  std::size_t corners = 0;
  for (const Polygon& polygon : obstacles.polygons) corners += polygon.corners.size();
  if (corners > kMaxCorners) {
    return FieldViolation("obstacles.polygons", "expected at most {} corners in total, got {}",
                          kMaxCorners, corners);
  }
  for (std::size_t i = 0; i < obstacles.discs.size(); ++i) {
    const std::string field = fmt::format("obstacles.discs[{}]", i);
    MOTIONDB_RETURN_IF_ERROR(CheckPoint(field + ".centre", obstacles.discs[i].centre));
    MOTIONDB_RETURN_IF_ERROR(
        CheckPositive(field + ".radius_m", obstacles.discs[i].radius_m, kMaxObstacle_m));
  }
  for (std::size_t i = 0; i < obstacles.polygons.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(
        CheckCorners(fmt::format("obstacles.polygons[{}].corners", i), obstacles.polygons[i]));
  }
  return CheckBetween("obstacles.clearance_m", obstacles.clearance_m, 0, kMaxObstacle_m);
}

absl::Status CheckProblem(const Model& model, const PlanProblem& problem) {
  MOTIONDB_RETURN_IF_ERROR(CheckGoal(problem.goal));
  MOTIONDB_RETURN_IF_ERROR(CheckNotNegative("position_tolerance_m", problem.position_tolerance_m));
  MOTIONDB_RETURN_IF_ERROR(
      CheckNotNegative("heading_tolerance_rad", problem.heading_tolerance_rad));
  MOTIONDB_RETURN_IF_ERROR(
      CheckPositive("max_duration_seconds", problem.max_duration_seconds, kMaxMotionSeconds));
  MOTIONDB_RETURN_IF_ERROR(CheckNotNegative("effort", problem.effort));
  if (problem.coarse_layer) {
    MOTIONDB_RETURN_IF_ERROR(
        CheckBetween("coarse_layer", *problem.coarse_layer, 1, model.layer_count()));
  }
  MOTIONDB_RETURN_IF_ERROR(
      CheckBetween("alternative_count", problem.alternative_count, 0, kMaxAlternatives));
  MOTIONDB_RETURN_IF_ERROR(CheckFrames(problem, model.settings().frame_rate_hz));
  MOTIONDB_RETURN_IF_ERROR(CheckPositive("speed_limit_scale", problem.speed_limit_scale, 1));
  if (problem.max_joint_acceleration) {
    MOTIONDB_RETURN_IF_ERROR(
        CheckPositive("max_joint_acceleration", *problem.max_joint_acceleration, kMaxAcceleration));
  }
  if (problem.leg_length_m &&
      !(*problem.leg_length_m > 0 && std::isfinite(*problem.leg_length_m))) {
    return FieldViolation("leg_length_m", "expected above 0, got {}", *problem.leg_length_m);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckLabels(model, problem.playable));
  return CheckObstacles(problem.obstacles);
}

}  // namespace motiondb::core
