#include "core/planning/obstacles.h"

#include <algorithm>
#include <limits>

namespace motiondb::core {
namespace {

double DistanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& from,
                         const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  const double squared = along.squaredNorm();
  const double share =
      squared > 0 ? std::clamp((point - from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (point - from - share * along).norm();
}

// Negative inside. A ray to the right crosses the line an odd number of times from within.
double Distance(const Polygon& polygon, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (std::size_t i = 0, last = polygon.corners.size() - 1; i < polygon.corners.size();
       last = i++) {
    const Eigen::Vector2d& a = polygon.corners[last];
    const Eigen::Vector2d& b = polygon.corners[i];
    nearest = std::min(nearest, DistanceToSegment(point, a, b));
    if ((a.y() > point.y()) != (b.y() > point.y()) &&
        point.x() < a.x() + (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y())) {
      inside = !inside;
    }
  }
  return inside ? -nearest : nearest;
}

}  // namespace

double Distance(const Obstacles& obstacles, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Disc& disc : obstacles.discs) {
    nearest = std::min(nearest, (point - disc.centre).norm() - disc.radius_m);
  }
  for (const Polygon& polygon : obstacles.polygons) {
    nearest = std::min(nearest, Distance(polygon, point));
  }
  return nearest;
}

}  // namespace motiondb::core
