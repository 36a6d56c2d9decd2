// Legs and arms in a hierarchy: pairs of equal chains of bones, and which joint is which.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mapping/bone_tree.h"

namespace motiondb::core {

// A limb: a chain of joints, and the joints that bend. Indices of joints; -1: none.
struct Limb {
  int inner = -1;  // clavicle, or a joint between pelvis and hip
  int upper = -1;  // hip or shoulder
  int middle = -1;
  int lower = -1;  // ankle or wrist
  int end = -1;    // ball of the foot, or knuckles
  int tip = -1;    // last joint of the chain
  double upper_length = 0;
  double lower_length = 0;
  double before = 0;       // from the branching to `upper`
  double after = 0;        // from `lower` to `tip`
  double name_score = 0;   // 0 to 1: mean fit of the names of upper, middle and lower
  double shape_score = 0;  // 0 to 1: how much the lengths are those of a person

  double length() const { return upper_length + lower_length; }
  double score() const { return 2 * name_score + shape_score; }
};

// Two limbs of equal lengths at one joint.
struct LimbPair {
  int branching = -1;
  std::array<int, 2> roots = {-1, -1};  // first joints of both chains
  std::array<Limb, 2> as_legs;
  std::array<Limb, 2> as_arms;
  double symmetry = 0;  // 0 to 1

  double leg_score() const { return as_legs[0].score() + as_legs[1].score() + 2 * symmetry; }
  double arm_score() const { return as_arms[0].score() + as_arms[1].score() + 2 * symmetry; }
};

// Returns the pairs that may be legs or arms: the best kMaxPairs, so that a search over all
// combinations is bounded for any hierarchy. Pairs of different sides if the names tell sides.
inline constexpr std::size_t kMaxPairs = 64;
std::vector<LimbPair> FindLimbPairs(const BoneTree& tree);

}  // namespace motiondb::core
