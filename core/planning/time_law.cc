#include "core/planning/time_law.h"

#include <algorithm>
#include <cmath>

namespace motiondb::core {
namespace {

constexpr double kCell = 0.5;           // steps of the path
constexpr double kChangeSeconds = 0.2;  // to reach the recorded speed from rest
constexpr double kReported = 1.001;     // smallest factor of a slowed part

// The absolute path derivatives of all coordinates, largest in a cell: 1 x coordinates each.
struct CellBounds {
  Eigen::ArrayXd first;
  Eigen::ArrayXd second;
};

// In a cell, the first derivative of the spline is a quadratic Bezier curve, which its control
// points bound; the second is linear, so it is largest at an end.
std::vector<CellBounds> BoundCells(const JointMatrix& steps) {
  const Eigen::Index last = steps.rows() - 1;
  const auto step = [&](Eigen::Index i) {
    return steps.row(std::clamp<Eigen::Index>(i, 0, last)).transpose().array();
  };
  std::vector<CellBounds> cells;
  for (Eigen::Index i = 0; i <= last; ++i) {
    const Eigen::ArrayXd before = step(i - 1);
    const Eigen::ArrayXd own = step(i);
    const Eigen::ArrayXd after = step(i + 1);
    const Eigen::ArrayXd first_middle = (before + 6 * own + after).abs() / 8;
    const Eigen::ArrayXd second_middle = (after - before).abs() / 2;
    cells.push_back({((before + own).abs() / 2).max((before + 3 * own).abs() / 4).max(first_middle),
                     (own - before).abs().max(second_middle)});
    cells.push_back({((own + after).abs() / 2).max((3 * own + after).abs() / 4).max(first_middle),
                     (after - own).abs().max(second_middle)});
  }
  return cells;
}

// A bound of the squared speed, and the limit that it comes from.
struct Bound {
  double squared;
  BindingLimit limit;

  void Lower(double to, BindingLimit by) {
    if (to < squared) *this = {to, by};
  }
};

class PhasePlane {
 public:
  PhasePlane(const JointMatrix& steps, double recorded_hz, const RateLimits& limits)
      : cells_(BoundCells(steps)), limits_(limits), change_(recorded_hz / kChangeSeconds) {
    const Bound recorded{recorded_hz * recorded_hz, {}};
    points_.assign(cells_.size() + 1, recorded);
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      Bound cell = recorded;
      for (Eigen::Index j = 0; j < cells_[c].first.size(); ++j) {
        const int at = static_cast<int>(j);
        const double ratio = limits.speed[j] / cells_[c].first[j];
        cell.Lower(ratio * ratio, {at, LimitKind::kSpeed});
        cell.Lower(limits.acceleration[j] / cells_[c].second[j], {at, LimitKind::kAcceleration});
      }
      points_[c].Lower(cell.squared, cell.limit);
      points_[c + 1].Lower(cell.squared, cell.limit);
    }
    for (std::size_t c = cells_.size(); c-- > 0;) Limit(cells_[c], points_[c + 1], points_[c]);
    for (std::size_t c = 0; c < cells_.size(); ++c) Limit(cells_[c], points_[c], points_[c + 1]);
  }

  const std::vector<Bound>& points() const { return points_; }

 private:
  // Lowers the squared speed at one end of a cell to what can be reached from the other end.
  void Limit(const CellBounds& cell, const Bound& from, Bound& to) const {
    if (to.squared <= from.squared) return;
    // The limit that slows the other end also explains this one.
    to.Lower(from.squared + 2 * kCell * change_, from.limit);
    for (Eigen::Index j = 0; j < cell.first.size(); ++j) {
      const double allowed = limits_.acceleration[j];
      if (std::isinf(allowed) || cell.first[j] == 0) continue;
      to.Lower((from.squared * cell.first[j] + 2 * kCell * allowed) /
                   (cell.first[j] + 2 * kCell * cell.second[j]),
               {static_cast<int>(j), LimitKind::kAcceleration});
    }
  }

  std::vector<CellBounds> cells_;
  const RateLimits& limits_;
  double change_;  // maximum acceleration of the place
  std::vector<Bound> points_;
};

}  // namespace

TimeLaw::TimeLaw(const JointMatrix& steps, double recorded_hz, const RateLimits& limits) {
  const PhasePlane plane(steps, recorded_hz, limits);
  std::vector<BindingLimit> binding;
  for (const Bound& point : plane.points()) {
    const double speed = std::sqrt(point.squared);
    seconds_.push_back(speeds_.empty() ? 0
                                       : seconds_.back() + 2 * kCell / (speeds_.back() + speed));
    speeds_.push_back(speed);
    binding.push_back(point.limit);
  }
  FindSlowedParts(recorded_hz, binding);
}

void TimeLaw::FindSlowedParts(double recorded_hz, const std::vector<BindingLimit>& binding) {
  for (std::size_t g = 0; g < binding.size(); ++g) {
    const double factor = recorded_hz / speeds_[g];
    if (binding[g].coordinate < 0 || factor < kReported) continue;
    if (slowed_.empty() || slowed_.back().end_seconds < seconds_[g] ||
        !(slowed_.back().limit == binding[g])) {
      slowed_.push_back({seconds_[g], seconds_[g], binding[g], factor});
    }
    slowed_.back().factor = std::max(slowed_.back().factor, factor);
    slowed_.back().end_seconds = seconds_[std::min(g + 1, binding.size() - 1)];
  }
}

double TimeLaw::PlaceAt(double seconds) const {
  const auto after = std::upper_bound(seconds_.begin(), seconds_.end(), seconds);
  if (after == seconds_.begin()) return 0;
  const auto cell = static_cast<std::size_t>(after - seconds_.begin()) - 1;
  if (cell + 1 == seconds_.size()) return kCell * static_cast<double>(cell);
  const double passed = seconds - seconds_[cell];
  const double length = seconds_[cell + 1] - seconds_[cell];
  const double change = (speeds_[cell + 1] - speeds_[cell]) / length;
  return kCell * static_cast<double>(cell) +
         std::clamp(passed * (speeds_[cell] + change * passed / 2), 0.0, kCell);
}

void TimeLaw::Slow(double factor) {
  for (double& speed : speeds_) speed /= factor;
  for (double& second : seconds_) second *= factor;
  for (SlowedPart& part : slowed_) {
    part.start_seconds *= factor;
    part.end_seconds *= factor;
    part.factor *= factor;
  }
}

}  // namespace motiondb::core
