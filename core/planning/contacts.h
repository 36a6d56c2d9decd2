// Which points of the feet stand on the floor, and when. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

class Model;

// One foot: its leg, and the markers of the set that move with it.
struct Foot {
  std::array<int, 3> leg{};  // hip, knee, ankle
  // Those that touch the floor (heel, toe; the ankle alone where the set has no more), nearest the
  // floor first, and how high each is while it stands, in leg lengths.
  std::vector<int> contact_markers;
  std::vector<float> rest_heights;
  // All that move with the ankle as one body: it, those above, and others of the foot.
  std::vector<int> foot_markers;
  // Those that keep their place on the thigh (hip to knee) and on the shin (knee to ankle).
  std::vector<int> thigh_markers;
  std::vector<int> shin_markers;
};

using Feet = std::vector<Foot>;

// frames x contact markers of all feet, in order of foot and marker: true where it stands.
using ContactMatrix = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The feet of the model's marker set, told from its stored frames (at most a few thousand are
// looked at, evenly). Empty where the set has no whole leg. O(frames looked at * markers).
Feet FindFeet(const Model& model);

// Contacts of a run of marker positions (frames x 3 N_v, m, world, floor at z = 0) of a subject of
// that leg length: low (near its rest height) and slow, for long enough. A marker that is missing
// (NaN) does not stand. O(frames * contact markers).
ContactMatrix DetectContacts(const Feet& feet, const FrameMatrix& positions_m, double frame_rate_hz,
                             double leg_length_m);

}  // namespace motiondb::core
