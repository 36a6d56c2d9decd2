#include "core/planning/foot_lock.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/model/model.h"
#include "core/planning/foot_hold.h"
#include "core/planning/smoothing.h"

namespace motiondb::core {
namespace {

// Half the time over which a foot is raised.
constexpr double kRaiseSeconds = 0.1;
// A leg is not stretched beyond this part of its length, unless it was.
constexpr double kStretch = 0.9995;

using Values = Eigen::ArrayXd;  // frames

// How far a foot must be raised so that none of its markers is below its rest height.
Values RaiseToFloor(const Foot& foot, double leg_length_m, double rate_hz,
                    const FrameMatrix& positions_m) {
  Values raise = Values::Zero(positions_m.rows());
  for (std::size_t i = 0; i < foot.contact_markers.size(); ++i) {
    raise = raise.max(foot.rest_heights[i] * leg_length_m -
                      positions_m.col(3 * foot.contact_markers[i] + 2).cast<double>().array());
  }
  return Cover(raise, FramesOf(kRaiseSeconds, rate_hz));
}

// Hip, knee and ankle in one frame.
struct Leg {
  Eigen::Vector3d hip;
  Eigen::Vector3d knee;
  Eigen::Vector3d ankle;

  double thigh() const { return (knee - hip).norm(); }
  double shin() const { return (ankle - knee).norm(); }
  // How far from the hip the ankle may be.
  double reach() const { return std::max((ankle - hip).norm(), kStretch * (thigh() + shin())); }
};

Eigen::Vector3d At(const FrameMatrix& positions_m, Eigen::Index frame, int marker) {
  return positions_m.row(frame).segment<3>(3 * marker).transpose().cast<double>();
}

Leg LegAt(const Foot& foot, const FrameMatrix& positions_m, Eigen::Index frame) {
  return {At(positions_m, frame, foot.leg[0]), At(positions_m, frame, foot.leg[1]),
          At(positions_m, frame, foot.leg[2])};
}

// Where a foot is to be: its shift on the floor and how far it is raised.
struct FootMove {
  FloorShift shift;
  Values raise;
};

// How far the whole body is raised, or lowered where negative: with its feet, but no further than
// the legs reach. A foot that is raised alone, or shifted away, would bend or stretch a straight
// leg, and the knee would leap.
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
      const double aside = down.head<2>().norm();
      if (aside < reach) {
        highest[t] = std::min(highest[t], down.z() + std::sqrt(reach * reach - aside * aside));
      }
    }
  }
  return -Cover(-highest, FramesOf(kRaiseSeconds, rate_hz));
}

// The leg with its ankle elsewhere: the knee stays on its side, as far from both as it was. An
// ankle out of reach is brought nearer.
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
  // A straight leg bends to the toes.
  if (bend.norm() < 1e-6 * leg.thigh()) bend = toes - along * along.dot(toes);
  bend = (Eigen::Quaterniond::FromTwoVectors(along, new_along) * bend).normalized();
  const double thigh = leg.thigh();
  const double forth =
      (thigh * thigh - leg.shin() * leg.shin() + distance * distance) / (2 * distance);
  const double aside = std::sqrt(std::max(0.0, thigh * thigh - forth * forth));
  return {leg.hip, leg.hip + forth * new_along + aside * bend, ankle};
}

void Put(const Eigen::Vector3d& place, Eigen::Index frame, int marker, FrameMatrix& positions_m) {
  positions_m.row(frame).segment<3>(3 * marker) = place.transpose().cast<float>();
}

// Moves what lies along the segment from `from` to `to` to where that segment is now.
void Carry(const std::vector<int>& markers, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
           const Eigen::Vector3d& new_from, const Eigen::Vector3d& new_to, Eigen::Index frame,
           FrameMatrix& positions_m) {
  const auto turn = Eigen::Quaterniond::FromTwoVectors(to - from, new_to - new_from);
  for (const int marker : markers) {
    Put(new_from + turn * (At(positions_m, frame, marker) - from), frame, marker, positions_m);
  }
}

// Moves a foot, and bends its leg, in one frame.
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
    moves.push_back({HoldFoot(foot, contacts.middleCols(column, markers), frame_rate_hz,
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

}  // namespace motiondb::core
