#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/plan.h"

namespace motiondb::core {
namespace {

constexpr double kFarthestGoalM = 1000;
constexpr double kLongestMotionSeconds = 120;
constexpr int kMostAlternatives = 10;
// Of all motions of an answer together: ten alternatives of 120 s at 120 Hz are 158,400.
constexpr double kMostFrames = 200'000;
constexpr std::size_t kShownLabels = 10;
constexpr std::size_t kMostObstacles = 1000;
constexpr std::size_t kMostCorners = 10'000;
constexpr std::size_t kMostCornersOfOne = 2'000;  // all pairs of its sides may have to be compared
constexpr double kFarthestObstacleM = 10'000;

absl::Status CheckBetween(std::string_view field, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return FieldViolation(field, "expected {} to {}, got {}", least, most, value);
}

absl::Status CheckPositive(std::string_view field, double value, double most) {
  if (value > 0 && value <= most) return absl::OkStatus();
  return FieldViolation(field, "expected more than 0, at most {}, got {}", most, value);
}

absl::Status CheckNotNegative(std::string_view field, double value) {
  if (value >= 0 && std::isfinite(value)) return absl::OkStatus();
  return FieldViolation(field, "expected 0 or more, got {}", value);
}

absl::Status CheckGoal(const FloorPose& goal) {
  MOTIONDB_RETURN_IF_ERROR(CheckBetween("goal.x_m", goal.x, -kFarthestGoalM, kFarthestGoalM));
  MOTIONDB_RETURN_IF_ERROR(CheckBetween("goal.y_m", goal.y, -kFarthestGoalM, kFarthestGoalM));
  if (std::isfinite(goal.heading)) return absl::OkStatus();
  return FieldViolation("goal.heading_rad", "expected a finite number, got {}", goal.heading);
}

absl::Status CheckLabels(const Model& model, const std::vector<std::string>& labels) {
  std::set<std::string> known;
  for (const ModelClip& clip : model.clips()) known.insert(clip.label);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (known.contains(labels[i])) continue;
    const bool few = known.size() <= kShownLabels;
    return FieldViolation(
        fmt::format("labels[{}]", i), "no clip of the model has the label '{}'; it has {}",
        labels[i],
        few ? fmt::format("{}", fmt::join(known, ", ")) : fmt::format("{} others", known.size()));
  }
  return absl::OkStatus();
}

absl::Status CheckPoint(const std::string& field, const Eigen::Vector2d& point) {
  MOTIONDB_RETURN_IF_ERROR(
      CheckBetween(field + ".x_m", point.x(), -kFarthestObstacleM, kFarthestObstacleM));
  return CheckBetween(field + ".y_m", point.y(), -kFarthestObstacleM, kFarthestObstacleM);
}

absl::Status CheckCorners(const std::string& field, const Polygon& polygon) {
  if (polygon.corners.size() > kMostCornersOfOne) {
    return FieldViolation(field, "expected at most {}, got {}", kMostCornersOfOne,
                          polygon.corners.size());
  }
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(CheckPoint(fmt::format("{}[{}]", field, i), polygon.corners[i]));
  }
  const absl::Status status = CheckPolygon(polygon);
  return status.ok() ? status : FieldViolation(field, std::string(status.message()));
}

absl::Status CheckFrames(const PlanProblem& problem, double model_rate_hz) {
  if (problem.frame_rate_hz != 0) {
    MOTIONDB_RETURN_IF_ERROR(CheckBetween("frame_rate_hz", problem.frame_rate_hz,
                                          kLowestFrameRateHz, kHighestFrameRateHz));
  }
  const double rate = problem.frame_rate_hz > 0 ? problem.frame_rate_hz : model_rate_hz;
  const int motions = 1 + problem.alternative_count;
  if (rate * problem.max_duration_seconds * motions <= kMostFrames) return absl::OkStatus();
  return FieldViolation(
      "frame_rate_hz",
      "expected at most {} frames in all, got {} motions of up to {} s at {} Hz: ask for fewer or "
      "shorter ones, or a lower rate",
      kMostFrames, motions, problem.max_duration_seconds, rate);
}

}  // namespace

absl::Status CheckObstacles(const Obstacles& obstacles) {
  const std::size_t count = obstacles.discs.size() + obstacles.polygons.size();
  if (count > kMostObstacles) {
    return FieldViolation("obstacles", "expected at most {} obstacles, got {}", kMostObstacles,
                          count);
  }
  std::size_t corners = 0;
  for (const Polygon& polygon : obstacles.polygons) corners += polygon.corners.size();
  if (corners > kMostCorners) {
    return FieldViolation("obstacles.polygons", "expected at most {} corners in all, got {}",
                          kMostCorners, corners);
  }
  for (std::size_t i = 0; i < obstacles.discs.size(); ++i) {
    const std::string field = fmt::format("obstacles.discs[{}]", i);
    MOTIONDB_RETURN_IF_ERROR(CheckPoint(field + ".centre", obstacles.discs[i].centre));
    MOTIONDB_RETURN_IF_ERROR(
        CheckPositive(field + ".radius_m", obstacles.discs[i].radius_m, kFarthestObstacleM));
  }
  for (std::size_t i = 0; i < obstacles.polygons.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(
        CheckCorners(fmt::format("obstacles.polygons[{}].corners", i), obstacles.polygons[i]));
  }
  return CheckBetween("obstacles.clearance_m", obstacles.clearance_m, 0, kFarthestObstacleM);
}

absl::Status CheckProblem(const Model& model, const PlanProblem& problem) {
  MOTIONDB_RETURN_IF_ERROR(CheckGoal(problem.goal));
  MOTIONDB_RETURN_IF_ERROR(CheckNotNegative("position_tolerance_m", problem.position_tolerance_m));
  MOTIONDB_RETURN_IF_ERROR(
      CheckNotNegative("heading_tolerance_rad", problem.heading_tolerance_rad));
  MOTIONDB_RETURN_IF_ERROR(
      CheckPositive("max_duration_seconds", problem.max_duration_seconds, kLongestMotionSeconds));
  MOTIONDB_RETURN_IF_ERROR(CheckNotNegative("effort", problem.effort));
  MOTIONDB_RETURN_IF_ERROR(
      CheckBetween("coarse_layer", problem.coarse_layer, 0, model.layer_count()));
  MOTIONDB_RETURN_IF_ERROR(
      CheckBetween("alternative_count", problem.alternative_count, 0, kMostAlternatives));
  MOTIONDB_RETURN_IF_ERROR(CheckFrames(problem, model.settings().frame_rate_hz));
  if (problem.leg_length_m &&
      !(*problem.leg_length_m > 0 && std::isfinite(*problem.leg_length_m))) {
    return FieldViolation("leg_length_m", "expected more than 0, got {}", *problem.leg_length_m);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckLabels(model, problem.labels));
  return CheckObstacles(problem.obstacles);
}

}  // namespace motiondb::core
