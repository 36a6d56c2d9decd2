#include "core/planning/foot_lock.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/model/model.h"
#include "core/motion/forward_kinematics.h"
#include "core/planning/splice.h"

namespace motiondb::core {

namespace {

// Half the duration of raising a foot.
constexpr double kRaiseSeconds = 0.1;
// Maximum extension of a leg as a fraction of its length, unless the motion already exceeds it.
constexpr double kStretch = 0.9995;

using Values = Eigen::ArrayXd;  // frames

// Returns the height by which a foot must be raised so that no contact marker is below its rest
// height.
Values RaiseToFloor(const Foot& foot, double leg_length_m, double rate_hz,
                    const FrameMatrix& positions_m) {
  Values raise = Values::Zero(positions_m.rows());
  for (std::size_t i = 0; i < foot.contact_markers.size(); ++i) {
    raise = raise.max(foot.rest_heights[i] * leg_length_m -
                      positions_m.col(3 * foot.contact_markers[i] + 2).cast<double>().array());
  }
  return UpperEnvelope(raise, FramesOf(kRaiseSeconds, rate_hz));
}

// Hip, knee and ankle in one frame.
struct Leg {
  Eigen::Vector3d hip;
  Eigen::Vector3d knee;
  Eigen::Vector3d ankle;

  double thigh() const { return (knee - hip).norm(); }
  double shin() const { return (ankle - knee).norm(); }
  // Maximum distance of the ankle from the hip.
  double reach() const { return std::max((ankle - hip).norm(), kStretch * (thigh() + shin())); }
};

Eigen::Vector3d At(const FrameMatrix& positions_m, Eigen::Index frame, int marker) {
  return positions_m.row(frame).segment<3>(3 * marker).transpose().cast<double>();
}

Leg LegAt(const Foot& foot, const FrameMatrix& positions_m, Eigen::Index frame) {
  return {At(positions_m, frame, foot.leg[0]), At(positions_m, frame, foot.leg[1]),
          At(positions_m, frame, foot.leg[2])};
}

// Target of a foot: its shift on the floor and its raise.
struct FootMove {
  FloorShift shift;
  Values raise;
};

// Returns the raise of the whole body (negative: lowered): with its feet, limited by the reach of
// the legs. Moving only the foot would bend or stretch a straight leg, and the knee would jump.
Values MoveBody(const Feet& feet, const std::vector<FootMove>& moves, double rate_hz,
                const FrameMatrix& positions_m) {
  Values highest(positions_m.rows());
  for (Eigen::Index t = 0; t < positions_m.rows(); ++t) {
    highest[t] = 0;
    for (const FootMove& move : moves) highest[t] = std::max(highest[t], move.raise[t]);
    for (std::size_t f = 0; f < feet.size(); ++f) {
      const Leg leg = LegAt(feet[f], positions_m, t);
      const Eigen::Vector3d down =
          leg.ankle - leg.hip +
          Eigen::Vector3d(moves[f].shift(t, 0), moves[f].shift(t, 1), moves[f].raise[t]);
      const double reach = leg.reach();
      const double perpendicular = down.head<2>().norm();
      if (perpendicular < reach) {
        highest[t] = std::min(highest[t],
                              down.z() + std::sqrt(reach * reach - perpendicular * perpendicular));
      }
    }
  }
  return -UpperEnvelope(-highest, FramesOf(kRaiseSeconds, rate_hz));
}

// Returns the leg with its ankle moved: the knee stays on its side, at the same distances from hip
// and ankle. An ankle out of reach is moved closer.
Leg MoveAnkle(const Leg& leg, Eigen::Vector3d ankle, const Eigen::Vector3d& toes) {
  const Eigen::Vector3d along = (leg.ankle - leg.hip).normalized();
  const double reach = leg.reach();
  double distance = (ankle - leg.hip).norm();
  if (distance > reach) {
    ankle = leg.hip + (ankle - leg.hip) * (reach / distance);
    distance = reach;
  }
  const Eigen::Vector3d new_along = (ankle - leg.hip) / distance;
  Eigen::Vector3d bend = leg.knee - leg.hip;
  bend -= along * along.dot(bend);
  // A straight leg bends towards the toes.
  if (bend.norm() < 1e-6 * leg.thigh()) bend = toes - along * along.dot(toes);
  bend = (ShortestTurn(along, new_along) * bend).normalized();
  const double thigh = leg.thigh();
  const double along_leg =
      (thigh * thigh - leg.shin() * leg.shin() + distance * distance) / (2 * distance);
  const double perpendicular = std::sqrt(std::max(0.0, thigh * thigh - along_leg * along_leg));
  return {leg.hip, leg.hip + along_leg * new_along + perpendicular * bend, ankle};
}

void Put(const Eigen::Vector3d& place, Eigen::Index frame, int marker, FrameMatrix& positions_m) {
  positions_m.row(frame).segment<3>(3 * marker) = place.transpose().cast<float>();
}

// Moves markers of the segment from `from` to `to` to the segment's new position.
void Carry(const std::vector<int>& markers, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
           const Eigen::Vector3d& new_from, const Eigen::Vector3d& new_to, Eigen::Index frame,
           FrameMatrix& positions_m) {
  const auto turn = ShortestTurn(to - from, new_to - new_from);
  for (const int marker : markers) {
    Put(new_from + turn * (At(positions_m, frame, marker) - from), frame, marker, positions_m);
  }
}

// Moves a foot and bends its leg in one frame.
void MoveFoot(const Foot& foot, const Eigen::Vector3d& move, Eigen::Index frame,
              FrameMatrix& positions_m) {
  const Leg old = LegAt(foot, positions_m, frame);
  Eigen::Vector3d toes = Eigen::Vector3d::Zero();
  for (const int marker : foot.foot_markers) toes += At(positions_m, frame, marker) - old.ankle;
  const Leg leg = MoveAnkle(old, old.ankle + move, toes);
  Carry(foot.thigh_markers, old.hip, old.knee, leg.hip, leg.knee, frame, positions_m);
  Carry(foot.shin_markers, old.knee, old.ankle, leg.knee, leg.ankle, frame, positions_m);
  Put(leg.knee, frame, foot.leg[1], positions_m);
  for (const int marker : foot.foot_markers) {
    Put(At(positions_m, frame, marker) + leg.ankle - old.ankle, frame, marker, positions_m);
  }
}

}  // namespace

void LockFeet(const Feet& feet, const ContactMatrix& contacts, double frame_rate_hz,
              double leg_length_m, FrameMatrix& positions_m) {
  if (feet.empty()) return;
  std::vector<FootMove> moves;
  Eigen::Index column = 0;
  for (const Foot& foot : feet) {
    const auto markers = static_cast<Eigen::Index>(foot.contact_markers.size());
    moves.push_back({FootShift(foot, contacts.middleCols(column, markers), frame_rate_hz,
                               leg_length_m, positions_m),
                     RaiseToFloor(foot, leg_length_m, frame_rate_hz, positions_m)});
    column += markers;
  }
  const Values body = MoveBody(feet, moves, frame_rate_hz, positions_m);
  for (Eigen::Index t = 0; t < positions_m.rows(); ++t) {
    for (Eigen::Index c = 2; c < positions_m.cols(); c += 3) {
      positions_m(t, c) += static_cast<float>(body[t]);
    }
    for (std::size_t f = 0; f < feet.size(); ++f) {
      MoveFoot(feet[f], {moves[f].shift(t, 0), moves[f].shift(t, 1), moves[f].raise[t] - body[t]},
               t, positions_m);
    }
  }
}

namespace {

// Half the duration in which a landed foot comes to rest, and leaves rest before take-off: stopping
// in one frame would be a jerk.
constexpr double kSettleSeconds = 0.015;
// Minimum duration of a swing: after a shorter one, the foot is in the same stance.
constexpr double kMinSwingSeconds = 0.15;
// Half the duration in which the support point moves from heel to toe.
constexpr double kHandOverSeconds = 0.04;
// Minimum distance (m) that a change of the support point must save.
constexpr double kHandOverCost_m = 0.002;
// Shifts are unlimited up to the first and bounded by the second, in leg lengths: a foot that moves
// further is not standing.
constexpr double kFreeShift = 0.1;
constexpr double kMaxShift = 0.2;
// Duration of easing a shift in or out between stances.
constexpr double kEaseSeconds = 0.25;

// Frames, both included, from the first contact of a foot to its swing to another position.
struct Stance {
  Eigen::Index first;
  Eigen::Index last;
};

std::vector<Stance> FindStances(const ContactMatrix& contacts, double rate_hz) {
  const Eigen::Index shortest_swing = FramesOf(kMinSwingSeconds, rate_hz);
  std::vector<Stance> stances;
  for (Eigen::Index t = 0; t < contacts.rows(); ++t) {
    if (!contacts.row(t).any()) continue;
    if (stances.empty() || t - stances.back().last > shortest_swing) stances.push_back({t, t});
    stances.back().last = t;
  }
  return stances;
}

// Returns how firmly a foot is held in each step between frames: 1 in contact, 0 off the floor.
Eigen::ArrayXd Firmness(const ContactMatrix& contacts, double rate_hz) {
  Eigen::ArrayXd loose(std::max<Eigen::Index>(0, contacts.rows() - 1));
  for (Eigen::Index t = 0; t < loose.size(); ++t) {
    loose[t] = contacts.row(t).any() && contacts.row(t + 1).any() ? 0 : 1;
  }
  return 1 - UpperEnvelope(loose, FramesOf(kSettleSeconds, rate_hz));
}

// Returns the displacement on the floor of each contact marker in each step of a stance: [marker]
// steps x 2.
std::vector<FloorShift> Displacements(const Foot& foot, const Stance& stance,
                                      const FrameMatrix& positions_m) {
  const Eigen::Index steps = stance.last - stance.first;
  std::vector<FloorShift> displacements;
  for (const int marker : foot.contact_markers) {
    const auto places =
        positions_m.block(stance.first, 3 * marker, steps + 1, 2).cast<double>().array();
    displacements.emplace_back(places.bottomRows(steps) - places.topRows(steps));
  }
  return displacements;
}

// Returns the support marker in each step of a stance: the sequence of markers in contact with the
// shortest path, where each change costs kHandOverCost_m. steps x markers, a single 1 in each row.
Eigen::ArrayXXd Pivots(const std::vector<FloorShift>& displacements, const ContactMatrix& contacts,
                       const Stance& stance) {
  const Eigen::Index steps = stance.last - stance.first;
  const auto markers = static_cast<Eigen::Index>(displacements.size());
  constexpr double kForbidden = 1e6;
  Eigen::ArrayXXd cost(steps, markers);
  Eigen::ArrayXXi from(steps, markers);
  for (Eigen::Index t = 0; t < steps; ++t) {
    for (Eigen::Index i = 0; i < markers; ++i) {
      const bool stands = contacts(stance.first + t, i) || contacts(stance.first + t + 1, i);
      cost(t, i) = stands ? displacements[i].row(t).matrix().norm() : kForbidden;
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

// Returns the factor that limits a shift (leg lengths).
double Limited(double length) {
  if (length <= kFreeShift) return 1;
  constexpr double kRange = kMaxShift - kFreeShift;
  return (kFreeShift + kRange * std::tanh((length - kFreeShift) / kRange)) / length;
}

// Returns the shift, with mean 0, that keeps a foot in place over one stance.
FloorShift HoldStance(const Foot& foot, const ContactMatrix& contacts,
                      const Eigen::ArrayXd& firmness, const Stance& stance, double rate_hz,
                      double leg_length_m, const FrameMatrix& positions_m) {
  const Eigen::Index steps = stance.last - stance.first;
  FloorShift shift = FloorShift::Zero(steps + 1, 2);
  if (steps == 0) return shift;
  const std::vector<FloorShift> displacements = Displacements(foot, stance, positions_m);
  const Eigen::ArrayXXd weights =
      Smooth(Pivots(displacements, contacts, stance), FramesOf(kHandOverSeconds, rate_hz));
  for (Eigen::Index t = 0; t < steps; ++t) {
    shift.row(t + 1) = shift.row(t);
    for (std::size_t i = 0; i < displacements.size(); ++i) {
      shift.row(t + 1) -= firmness[stance.first + t] * weights(t, static_cast<Eigen::Index>(i)) *
                          displacements[i].row(t);
    }
  }
  shift.rowwise() -= shift.colwise().mean().eval();
  for (Eigen::Index t = 0; t <= steps; ++t) {
    shift.row(t) *= Limited(shift.row(t).matrix().norm() / leg_length_m);
  }
  return shift;
}

}  // namespace

FloorShift FootShift(const Foot& foot, const ContactMatrix& contacts, double frame_rate_hz,
                     double leg_length_m, const FrameMatrix& positions_m) {
  const Eigen::Index frames = positions_m.rows();
  FloorShift shift = FloorShift::Zero(frames, 2);
  const Eigen::ArrayXd firmness = Firmness(contacts, frame_rate_hz);
  const Eigen::Index ease = FramesOf(kEaseSeconds, frame_rate_hz);
  // Interpolates the rows between `first` and `last`, which are set.
  const auto bridge = [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index t = first + 1; t < last; ++t) {
      const double u = Ease(static_cast<double>(t - first) / static_cast<double>(last - first));
      shift.row(t) = (1 - u) * shift.row(first) + u * shift.row(last);
    }
  };
  Eigen::Index before = -1;  // the last frame of the previous stance
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
