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

constexpr double kCell = 0.1;  // m
constexpr double kMostCells = 1e5;
constexpr double kMargin = 3;      // m of floor around start and goal
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
  enclosed_ = true;
  const double margin = kMargin + obstacles.clearance_m;
  origin_ = (start.cwiseMin(goal).array() - margin).matrix();
  const Eigen::Vector2d size = (start - goal).cwiseAbs().array() + 2 * margin;
  const double most_cells =
      std::min(kMostCells, kMostWork / static_cast<double>(CornerCount(obstacles)));
  cell_m_ = std::max(kCell, std::sqrt(size.x() * size.y() / most_cells));
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
  // Beyond its edge anything may be free: from there it is the straight line. But who cannot leave
  // the goal cannot come to it.
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
