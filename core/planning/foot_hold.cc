#include "core/planning/foot_hold.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"
#include "core/planning/ease.h"
#include "core/planning/smoothing.h"

namespace motiondb::core {
namespace {

// Half the time over which a foot that has landed comes to rest, and leaves it before it takes off:
// stopping it in one frame would be a jerk.
constexpr double kSettleSeconds = 0.015;
// A foot that is off the floor for less is not moved elsewhere meanwhile.
constexpr double kShortestSwingSeconds = 0.15;
// Half the time in which the place where a foot stands passes from heel to toe.
constexpr double kHandOverSeconds = 0.04;
// The way (m) that a change of that place must save.
constexpr double kHandOverCost_m = 0.002;
// A shift is let grow up to the first and held below the second, in leg lengths: a foot that
// shuffles further than that is not standing.
constexpr double kFreeShift = 0.1;
constexpr double kLargestShift = 0.2;
// Between stances a shift is eased in or out over this time.
constexpr double kEaseSeconds = 0.25;

// Frames, both included, from where a foot begins to stand to where it swings to another place.
struct Stance {
  Eigen::Index first;
  Eigen::Index last;
};

std::vector<Stance> FindStances(const ContactMatrix& contacts, double rate_hz) {
  const Eigen::Index shortest_swing = FramesOf(kShortestSwingSeconds, rate_hz);
  std::vector<Stance> stances;
  for (Eigen::Index t = 0; t < contacts.rows(); ++t) {
    if (!contacts.row(t).any()) continue;
    if (stances.empty() || t - stances.back().last > shortest_swing) stances.push_back({t, t});
    stances.back().last = t;
  }
  return stances;
}

// How firmly a foot is held in each step from a frame to the next: 1 while it stands, 0 while it
// does not.
Eigen::ArrayXd Firmness(const ContactMatrix& contacts, double rate_hz) {
  Eigen::ArrayXd loose(std::max<Eigen::Index>(0, contacts.rows() - 1));
  for (Eigen::Index t = 0; t < loose.size(); ++t) {
    loose[t] = contacts.row(t).any() && contacts.row(t + 1).any() ? 0 : 1;
  }
  return 1 - Cover(loose, FramesOf(kSettleSeconds, rate_hz));
}

// The way on the floor of each contact marker in each step of a stance: [marker] steps x 2.
std::vector<FloorShift> Ways(const Foot& foot, const Stance& stance,
                             const FrameMatrix& positions_m) {
  const Eigen::Index steps = stance.last - stance.first;
  std::vector<FloorShift> ways;
  for (const int marker : foot.contact_markers) {
    const auto places =
        positions_m.block(stance.first, 3 * marker, steps + 1, 2).cast<double>().array();
    ways.emplace_back(places.bottomRows(steps) - places.topRows(steps));
  }
  return ways;
}

// For each step of a stance the contact marker that the foot stands on: the sequence of markers in
// contact with the shortest way, where each change costs kHandOverCost_m. steps x markers, one 1 a
// row.
Eigen::ArrayXXd Pivots(const std::vector<FloorShift>& ways, const ContactMatrix& contacts,
                       const Stance& stance) {
  const Eigen::Index steps = stance.last - stance.first;
  const auto markers = static_cast<Eigen::Index>(ways.size());
  constexpr double kNever = 1e6;
  Eigen::ArrayXXd cost(steps, markers);
  Eigen::ArrayXXi from(steps, markers);
  for (Eigen::Index t = 0; t < steps; ++t) {
    for (Eigen::Index i = 0; i < markers; ++i) {
      const bool stands = contacts(stance.first + t, i) || contacts(stance.first + t + 1, i);
      cost(t, i) = stands ? ways[i].row(t).matrix().norm() : kNever;
      from(t, i) = static_cast<int>(i);
      if (t == 0) continue;
      Eigen::Index best = 0;
      const double other = cost.row(t - 1).minCoeff(&best) + kHandOverCost_m;
      if (other < cost(t - 1, i)) from(t, i) = static_cast<int>(best);
      cost(t, i) += std::min(other, cost(t - 1, i));
    }
  }
  Eigen::ArrayXXd pivots = Eigen::ArrayXXd::Zero(steps, markers);
  Eigen::Index at = 0;
  cost.row(steps - 1).minCoeff(&at);
  for (Eigen::Index t = steps - 1; t >= 0; --t) {
    pivots(t, at) = 1;
    at = from(t, at);
  }
  return pivots;
}

// What part of a shift (leg lengths) is kept.
double Limited(double length) {
  if (length <= kFreeShift) return 1;
  constexpr double kMore = kLargestShift - kFreeShift;
  return (kFreeShift + kMore * std::tanh((length - kFreeShift) / kMore)) / length;
}

// What keeps a foot in its place over one stance, about as little as will do: mean 0.
FloorShift HoldStance(const Foot& foot, const ContactMatrix& contacts,
                      const Eigen::ArrayXd& firmness, const Stance& stance, double rate_hz,
                      double leg_length_m, const FrameMatrix& positions_m) {
  const Eigen::Index steps = stance.last - stance.first;
  FloorShift shift = FloorShift::Zero(steps + 1, 2);
  if (steps == 0) return shift;
  const std::vector<FloorShift> ways = Ways(foot, stance, positions_m);
  const Eigen::ArrayXXd weights =
      Smooth(Pivots(ways, contacts, stance), FramesOf(kHandOverSeconds, rate_hz));
  for (Eigen::Index t = 0; t < steps; ++t) {
    shift.row(t + 1) = shift.row(t);
    for (std::size_t i = 0; i < ways.size(); ++i) {
      shift.row(t + 1) -=
          firmness[stance.first + t] * weights(t, static_cast<Eigen::Index>(i)) * ways[i].row(t);
    }
  }
  shift.rowwise() -= shift.colwise().mean().eval();
  for (Eigen::Index t = 0; t <= steps; ++t) {
    shift.row(t) *= Limited(shift.row(t).matrix().norm() / leg_length_m);
  }
  return shift;
}

}  // namespace

FloorShift HoldFoot(const Foot& foot, const ContactMatrix& contacts, double frame_rate_hz,
                    double leg_length_m, const FrameMatrix& positions_m) {
  const Eigen::Index frames = positions_m.rows();
  FloorShift shift = FloorShift::Zero(frames, 2);
  const Eigen::ArrayXd firmness = Firmness(contacts, frame_rate_hz);
  const Eigen::Index ease = FramesOf(kEaseSeconds, frame_rate_hz);
  // From row `first` to row `last`, which are set, over the rows between.
  const auto bridge = [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index t = first + 1; t < last; ++t) {
      const double u = Ease(static_cast<double>(t - first) / static_cast<double>(last - first));
      shift.row(t) = (1 - u) * shift.row(first) + u * shift.row(last);
    }
  };
  Eigen::Index before = -1;  // the last frame of the stance before
  for (const Stance& stance : FindStances(contacts, frame_rate_hz)) {
    shift.middleRows(stance.first, stance.last - stance.first + 1) =
        HoldStance(foot, contacts, firmness, stance, frame_rate_hz, leg_length_m, positions_m);
    if (before >= 0 && stance.first - before <= 2 * ease) {
      bridge(before, stance.first);
    } else {
      if (before >= 0) bridge(before, before + ease);
      if (stance.first >= ease) {
        bridge(stance.first - ease, stance.first);
      } else {  // the motion begins too late to ease in
        shift.topRows(stance.first).rowwise() = shift.row(stance.first).eval();
      }
    }
    before = stance.last;
  }
  if (before >= 0 && before + ease < frames) {
    bridge(before, before + ease);
  } else if (before >= 0) {
    shift.bottomRows(frames - 1 - before).rowwise() = shift.row(before).eval();
  }
  return shift;
}

}  // namespace motiondb::core
