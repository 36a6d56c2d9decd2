// Contacts of the feet with the floor.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

class Model;
struct MarkerSet;

// One foot: its leg, and the markers that move with it.
struct Foot {
  std::array<int, 3> leg{};  // hip, knee, ankle
  // Markers that touch the floor (heel, toe; the ankle if the set has no other), lowest first, with
  // their heights at rest in leg lengths.
  std::vector<int> contact_markers;
  std::vector<float> rest_heights;
  // Markers that move rigidly with the ankle: the ankle, contact markers and others of the foot.
  std::vector<int> foot_markers;
  // Markers fixed to the thigh (hip to knee) and to the shin (knee to ankle).
  std::vector<int> thigh_markers;
  std::vector<int> shin_markers;
};

using Feet = std::vector<Foot>;

// frames x contact markers of all feet, in order of foot and marker: true if in contact.
using ContactMatrix = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Returns the feet of the model's marker set, determined from a sample of at most a few thousand
// stored frames. Empty if the set has no complete leg. O(sampled frames * markers).
Feet FindFeet(const Model& model);

// The same, from a sample of one motion (unscaled states) of the set.
Feet FindFeet(const MarkerSet& set, const Eigen::Ref<const FrameMatrix>& states);

// Returns the contacts in marker positions (frames x 3 N_v, m, world, floor at z = 0) of a subject
// with this leg length: low (near the rest height) and slow, for long enough. Missing markers (NaN)
// have no contact. O(frames * contact markers).
ContactMatrix DetectContacts(const Feet& feet, const FrameMatrix& positions_m, double frame_rate_hz,
                             double leg_length_m);

}  // namespace motiondb::core
