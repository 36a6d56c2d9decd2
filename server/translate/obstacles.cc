#include "server/translate/obstacles.h"

#include "core/motion/error.h"
#include "core/planning/polygon_check.h"
#include "motiondb/v1/plan.pb.h"
#include "server/translate/field_violation.h"
#include "server/translate/numbers.h"

namespace motiondb::server {
namespace {

constexpr int kMostObstacles = 1000;
constexpr int kMostCorners = 10'000;
constexpr int kMostCornersOfOne = 2'000;  // all pairs of its sides may have to be compared
constexpr double kFurthest = 10'000;      // m

absl::StatusOr<Eigen::Vector2d> PointFrom(const std::string& field, const v1::FloorPoint& point) {
  MOTIONDB_ASSIGN_OR_RETURN(const double x,
                            Between(field + ".x_m", point.x_m(), -kFurthest, kFurthest));
  MOTIONDB_ASSIGN_OR_RETURN(const double y,
                            Between(field + ".y_m", point.y_m(), -kFurthest, kFurthest));
  return Eigen::Vector2d(x, y);
}

absl::StatusOr<core::Disc> DiscFrom(const std::string& field, const v1::Disc& message) {
  if (!message.has_centre()) return FieldViolation(field + ".centre", "is missing");
  core::Disc disc;
  MOTIONDB_ASSIGN_OR_RETURN(disc.centre, PointFrom(field + ".centre", message.centre()));
  MOTIONDB_ASSIGN_OR_RETURN(disc.radius_m, Positive(field + ".radius_m", message.radius_m()));
  MOTIONDB_RETURN_IF_ERROR(Between(field + ".radius_m", disc.radius_m, 0, kFurthest).status());
  return disc;
}

absl::StatusOr<core::Polygon> PolygonFrom(const std::string& field, const v1::Polygon& message) {
  const std::string corners = field + ".corners";
  if (message.corners_size() > kMostCornersOfOne) {
    return FieldViolation(corners, "expected at most {}, got {}", kMostCornersOfOne,
                          message.corners_size());
  }
  core::Polygon polygon;
  for (int i = 0; i < message.corners_size(); ++i) {
    MOTIONDB_ASSIGN_OR_RETURN(polygon.corners.emplace_back(),
                              PointFrom(fmt::format("{}[{}]", corners, i), message.corners(i)));
  }
  if (const absl::Status status = core::CheckPolygon(polygon); !status.ok()) {
    return FieldViolation(corners, std::string(status.message()));
  }
  return polygon;
}

}  // namespace

absl::StatusOr<core::Obstacles> ObstaclesFrom(std::string_view field,
                                              const v1::Obstacles& message) {
  const int count = message.discs_size() + message.polygons_size();
  if (count > kMostObstacles) {
    return FieldViolation(field, "expected at most {} obstacles, got {}", kMostObstacles, count);
  }
  int corners = 0;
  for (const v1::Polygon& polygon : message.polygons()) corners += polygon.corners_size();
  if (corners > kMostCorners) {
    return FieldViolation(fmt::format("{}.polygons", field),
                          "expected at most {} corners in all, got {}", kMostCorners, corners);
  }
  core::Obstacles obstacles;
  for (int i = 0; i < message.discs_size(); ++i) {
    MOTIONDB_ASSIGN_OR_RETURN(obstacles.discs.emplace_back(),
                              DiscFrom(fmt::format("{}.discs[{}]", field, i), message.discs(i)));
  }
  for (int i = 0; i < message.polygons_size(); ++i) {
    MOTIONDB_ASSIGN_OR_RETURN(
        obstacles.polygons.emplace_back(),
        PolygonFrom(fmt::format("{}.polygons[{}]", field, i), message.polygons(i)));
  }
  if (message.has_clearance_m()) {
    MOTIONDB_ASSIGN_OR_RETURN(obstacles.clearance_m, Between(fmt::format("{}.clearance_m", field),
                                                             message.clearance_m(), 0, kFurthest));
  }
  return obstacles;
}

}  // namespace motiondb::server
