#include "core/planning/floor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>
#include <vector>

#include "core/motion/error.h"

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

// Signed distance, negative inside: from inside, a ray to the right crosses an odd number of sides.
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

namespace {

// A side of the polygon, and the corner at its start.
struct Side {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  std::size_t corner = 0;  // in the polygon
  std::size_t order = 0;   // among the sides

  double min_x() const { return std::min(from.x(), to.x()); }
  double max_x() const { return std::max(from.x(), to.x()); }
};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Returns the point's side of the line: 1, -1, or 0 on it.
int SideOf(const Side& line, const Eigen::Vector2d& point) {
  const double area = Cross(line.to - line.from, point - line.from);
  return (area > 0) - (area < 0);
}

// Whether a point on the side's line is between its ends.
bool Within(const Side& side, const Eigen::Vector2d& point) {
  return (point.array() >= side.from.cwiseMin(side.to).array()).all() &&
         (point.array() <= side.from.cwiseMax(side.to).array()).all();
}

bool Intersect(const Side& a, const Side& b) {
  const int b_from = SideOf(a, b.from);
  const int b_to = SideOf(a, b.to);
  const int a_from = SideOf(b, a.from);
  const int a_to = SideOf(b, a.to);
  if (b_from * b_to < 0 && a_from * a_to < 0) return true;
  return (b_from == 0 && Within(a, b.from)) || (b_to == 0 && Within(a, b.to)) ||
         (a_from == 0 && Within(b, a.from)) || (a_to == 0 && Within(b, a.to));
}

// Whether `next`, the side after `side`, overlaps it backwards.
bool GoesBack(const Side& side, const Side& next) {
  return SideOf(side, next.to) == 0 && (side.to - side.from).dot(next.to - next.from) < 0;
}

// Returns the sides of nonzero length.
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

absl::Status IntersectionError(const Side& a, const Side& b) {
  return InvalidArgument(
      "the sides from corners[{}] and corners[{}] intersect: expected a simple polygon",
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
    if (GoesBack(sides[i], next)) return IntersectionError(sides[i], next);
  }
  // Sweep from left to right: only sides that begin before this one ends can intersect it.
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.min_x() < b.min_x(); });
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count && sides[j].min_x() <= sides[i].max_x(); ++j) {
      const std::size_t apart = sides[i].order > sides[j].order ? sides[i].order - sides[j].order
                                                                : sides[j].order - sides[i].order;
      const bool neighbours = apart == 1 || apart == count - 1;
      if (!neighbours && Intersect(sides[i], sides[j]))
        return IntersectionError(sides[i], sides[j]);
    }
  }
  return absl::OkStatus();
}

namespace {

constexpr double kCell = 0.1;  // m
constexpr double kMaxCells = 1e5;
constexpr double kMargin = 3;     // m of floor around start and goal
constexpr double kMaxWork = 2e6;  // cells x corners
constexpr float kFar = std::numeric_limits<float>::infinity();
// Maximum ratio of the path length over eight neighbours to the straight line.
const double kDetour = 1 / std::cos(std::numbers::pi / 8);

std::size_t CornerCount(const Obstacles& obstacles) {
  std::size_t corners = obstacles.discs.size();
  for (const Polygon& polygon : obstacles.polygons) corners += polygon.corners.size();
  return corners;
}

}  // namespace

FloorField::FloorField(const Obstacles& obstacles, const Eigen::Vector2d& start,
                       const Eigen::Vector2d& goal)
    : obstacles_(obstacles), goal_(goal) {
  if (obstacles.empty()) return;
  enclosed_ = true;
  const double margin = kMargin + obstacles.clearance_m;
  origin_ = (start.cwiseMin(goal).array() - margin).matrix();
  const Eigen::Vector2d size = (start - goal).cwiseAbs().array() + 2 * margin;
  const double max_cells =
      std::min(kMaxCells, kMaxWork / static_cast<double>(CornerCount(obstacles)));
  cell_m_ = std::max(kCell, std::sqrt(size.x() * size.y() / max_cells));
  columns_ = static_cast<int>(size.x() / cell_m_) + 1;
  rows_ = static_cast<int>(size.y() / cell_m_) + 1;

  const double half_diagonal = cell_m_ / std::numbers::sqrt2;
  const auto middle_of = [&](int r, int c) -> Eigen::Vector2d {
    return origin_ + cell_m_ * Eigen::Vector2d(c + 0.5, r + 0.5);
  };
  const auto is_open = [&](int cell) {
    return to_obstacle_m_[cell] > obstacles.clearance_m - half_diagonal;
  };
  to_obstacle_m_.resize(static_cast<std::size_t>(columns_) * rows_);
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      to_obstacle_m_[r * columns_ + c] = static_cast<float>(Distance(obstacles, middle_of(r, c)));
    }
  }

  to_goal_m_.assign(to_obstacle_m_.size(), kFar);
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const auto begin_at = [&](int cell, double distance) {
    if (static_cast<float>(distance) >= to_goal_m_[cell]) return;
    to_goal_m_[cell] = static_cast<float>(distance);
    queue.push({to_goal_m_[cell], cell});
  };
  const auto spread = [&] {
    while (!queue.empty()) {
      const auto [distance, cell] = queue.top();
      queue.pop();
      if (distance > to_goal_m_[cell]) continue;
      for (int dr = -1; dr <= 1; ++dr) {
        for (int dc = -1; dc <= 1; ++dc) {
          const int r = cell / columns_ + dr;
          const int c = cell % columns_ + dc;
          if (r < 0 || r >= rows_ || c < 0 || c >= columns_ || !is_open(r * columns_ + c)) continue;
          begin_at(r * columns_ + c, distance + cell_m_ * std::hypot(dr, dc));
        }
      }
    }
  };
  begin_at(IndexAt(goal), 0);
  spread();
  // Outside the grid everything may be free: from the edge, distances are straight lines. But if no
  // path leaves the goal, no path reaches it.
  std::vector<std::pair<int, double>> edge;
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      const bool is_edge = r == 0 || c == 0 || r == rows_ - 1 || c == columns_ - 1;
      const int cell = r * columns_ + c;
      if (!is_edge || !is_open(cell)) continue;
      edge.emplace_back(cell, kDetour * (middle_of(r, c) - goal).norm());
      enclosed_ = enclosed_ && to_goal_m_[cell] == kFar;
    }
  }
  if (enclosed_) return;
  for (const auto& [cell, distance] : edge) begin_at(cell, distance);
  spread();
}

int FloorField::IndexAt(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d at = (point - origin_) / cell_m_;
  if (!(at.x() >= 0 && at.x() < columns_ && at.y() >= 0 && at.y() < rows_)) return -1;
  return static_cast<int>(at.y()) * columns_ + static_cast<int>(at.x());
}

double FloorField::DistanceToGoal(const Eigen::Vector2d& point) const {
  const double straight = (point - goal_).norm();
  if (cell_m_ == 0) return straight;
  const int cell = IndexAt(point);
  if (cell < 0) return enclosed_ ? kFar : straight;
  // Lower bound: the grid's path without its detours and the parts inside the two end cells.
  const double around = to_goal_m_[cell] / kDetour - 2 * std::numbers::sqrt2 * cell_m_;
  return std::max(straight, around);
}

bool FloorField::HasClearance(const Eigen::Vector2d& point, double distance_m) const {
  if (cell_m_ == 0) return true;
  const int cell = IndexAt(point);
  // Distances change at most as fast as the point moves. Rounding to float is below 0.1 mm on any
  // floor that can be crossed in time.
  if (cell >= 0) {
    const double half_diagonal = cell_m_ / std::numbers::sqrt2 + 1e-4;
    const double middle = to_obstacle_m_[cell];
    if (middle - half_diagonal >= distance_m) return true;
    if (middle + half_diagonal < distance_m) return false;
  }
  return Distance(obstacles_, point) >= distance_m;
}

}  // namespace motiondb::core
