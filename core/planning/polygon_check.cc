#include "core/planning/polygon_check.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/motion/error.h"

namespace motiondb::core {
namespace {

// A side of the polygon, and the corner that it begins at.
struct Side {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  std::size_t corner = 0;  // in the polygon
  std::size_t order = 0;   // among the sides

  double least_x() const { return std::min(from.x(), to.x()); }
  double greatest_x() const { return std::max(from.x(), to.x()); }
};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// On which side of the line the point is: 1, -1, or 0 on it.
int SideOf(const Side& line, const Eigen::Vector2d& point) {
  const double area = Cross(line.to - line.from, point - line.from);
  return (area > 0) - (area < 0);
}

// Whether a point of the line's is within the bounds of its side.
bool Within(const Side& side, const Eigen::Vector2d& point) {
  return (point.array() >= side.from.cwiseMin(side.to).array()).all() &&
         (point.array() <= side.from.cwiseMax(side.to).array()).all();
}

bool Meet(const Side& a, const Side& b) {
  const int b_from = SideOf(a, b.from);
  const int b_to = SideOf(a, b.to);
  const int a_from = SideOf(b, a.from);
  const int a_to = SideOf(b, a.to);
  if (b_from * b_to < 0 && a_from * a_to < 0) return true;
  return (b_from == 0 && Within(a, b.from)) || (b_to == 0 && Within(a, b.to)) ||
         (a_from == 0 && Within(b, a.from)) || (a_to == 0 && Within(b, a.to));
}

// `next` begins where `side` ends, and goes back along it.
bool GoesBack(const Side& side, const Side& next) {
  return SideOf(side, next.to) == 0 && (side.to - side.from).dot(next.to - next.from) < 0;
}

// Without those of no length.
std::vector<Side> SidesOf(const Polygon& polygon) {
  std::vector<Side> sides;
  const std::size_t count = polygon.corners.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d& from = polygon.corners[i];
    const Eigen::Vector2d& to = polygon.corners[(i + 1) % count];
    if (from != to) sides.push_back({from, to, i, sides.size()});
  }
  return sides;
}

absl::Status Bad(const Side& a, const Side& b) {
  return InvalidArgument(
      "the side from corners[{}] and the one from corners[{}] meet: the line must not touch itself",
      std::min(a.corner, b.corner), std::max(a.corner, b.corner));
}

}  // namespace

absl::Status CheckPolygon(const Polygon& polygon) {
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    if (!polygon.corners[i].allFinite()) {
      return InvalidArgument("corners[{}]: expected finite numbers, got {}, {}", i,
                             polygon.corners[i].x(), polygon.corners[i].y());
    }
  }
  std::vector<Side> sides = SidesOf(polygon);
  if (sides.size() < 3) {
    return InvalidArgument("expected at least 3 different corners, got {}",
                           std::max<std::size_t>(sides.size(), polygon.corners.empty() ? 0 : 1));
  }
  const std::size_t count = sides.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Side& next = sides[(i + 1) % count];
    if (GoesBack(sides[i], next)) return Bad(sides[i], next);
  }
  // From left to right: only sides that begin before this one ends can meet it.
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.least_x() < b.least_x(); });
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count && sides[j].least_x() <= sides[i].greatest_x(); ++j) {
      const std::size_t apart = sides[i].order > sides[j].order ? sides[i].order - sides[j].order
                                                                : sides[j].order - sides[i].order;
      const bool neighbours = apart == 1 || apart == count - 1;
      if (!neighbours && Meet(sides[i], sides[j])) return Bad(sides[i], sides[j]);
    }
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
