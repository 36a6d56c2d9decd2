#include "core/planning/floor_field.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

namespace motiondb::core {
namespace {

constexpr double kCell = 0.1;      // m
constexpr double kMargin = 3;      // m of floor around all that is known
constexpr double kMostWork = 2e6;  // cells x corners
constexpr float kFar = std::numeric_limits<float>::infinity();
// A way over eight neighbours is longer than the straight one by at most this.
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
  Eigen::Vector2d low = start.cwiseMin(goal);
  Eigen::Vector2d high = start.cwiseMax(goal);
  for (const Disc& disc : obstacles.discs) {
    low = low.cwiseMin((disc.centre.array() - disc.radius_m).matrix());
    high = high.cwiseMax((disc.centre.array() + disc.radius_m).matrix());
  }
  for (const Polygon& polygon : obstacles.polygons) {
    for (const Eigen::Vector2d& corner : polygon.corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  const double margin = kMargin + obstacles.clearance_m;
  origin_ = (low.array() - margin).matrix();
  const Eigen::Vector2d size = (high - low).array() + 2 * margin;
  const auto corners = static_cast<double>(CornerCount(obstacles));
  cell_m_ = std::max(kCell, std::sqrt(size.x() * size.y() * corners / kMostWork));
  columns_ = static_cast<int>(size.x() / cell_m_) + 1;
  rows_ = static_cast<int>(size.y() / cell_m_) + 1;

  const double half_diagonal = cell_m_ / std::numbers::sqrt2;
  to_obstacle_m_.resize(static_cast<std::size_t>(columns_) * rows_);
  for (int r = 0; r < rows_; ++r) {
    for (int c = 0; c < columns_; ++c) {
      const Eigen::Vector2d middle = origin_ + cell_m_ * Eigen::Vector2d(c + 0.5, r + 0.5);
      to_obstacle_m_[r * columns_ + c] = static_cast<float>(Distance(obstacles, middle));
    }
  }

  to_goal_m_.assign(to_obstacle_m_.size(), kFar);
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  const int goal_cell = IndexAt(goal);
  to_goal_m_[goal_cell] = 0;
  queue.push({0, goal_cell});
  while (!queue.empty()) {
    const auto [distance, cell] = queue.top();
    queue.pop();
    if (distance > to_goal_m_[cell]) continue;
    const int r = cell / columns_;
    const int c = cell % columns_;
    for (int dr = -1; dr <= 1; ++dr) {
      for (int dc = -1; dc <= 1; ++dc) {
        const int nr = r + dr;
        const int nc = c + dc;
        if (nr < 0 || nr >= rows_ || nc < 0 || nc >= columns_) continue;
        const int next = nr * columns_ + nc;
        const float way = distance + static_cast<float>(cell_m_ * std::hypot(dr, dc));
        const bool open = to_obstacle_m_[next] > obstacles.clearance_m - half_diagonal;
        if (!open || way >= to_goal_m_[next]) continue;
        to_goal_m_[next] = way;
        queue.push({way, next});
      }
    }
  }
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
  if (cell < 0) return straight;
  // The grid's way, less its detours and the two ends within their cells.
  const double around = to_goal_m_[cell] / kDetour - 2 * std::numbers::sqrt2 * cell_m_;
  return std::max(straight, around);
}

bool FloorField::Keeps(const Eigen::Vector2d& point, double distance_m) const {
  if (cell_m_ == 0) return true;
  const int cell = IndexAt(point);
  // Distances change no faster than the point moves, and rounding to float by less than a tenth of
  // a millimetre on any floor that can be walked in time.
  if (cell >= 0) {
    const double half_diagonal = cell_m_ / std::numbers::sqrt2 + 1e-4;
    const double middle = to_obstacle_m_[cell];
    if (middle - half_diagonal >= distance_m) return true;
    if (middle + half_diagonal < distance_m) return false;
  }
  return Distance(obstacles_, point) >= distance_m;
}

}  // namespace motiondb::core
