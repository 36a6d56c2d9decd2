// What can go wrong with an observation: the same motion as a worse sensor or another source would
// tell it. Everything random is seeded by the clip's name, so every run and method sees the same.
#pragma once

#include <string>
#include <vector>

#include "core/motion/marker_set.h"
#include "tests/eval/recognition_study.h"

namespace motiondb::tests {

struct Condition {
  std::string name;
  Observe whole;    // the clip
  Observe windows;  // its windows
  bool markers_missing = false;
};

// The first is the clean one. Beyond it: markers missing at random, a limb missing, noise, other
// frame rates. `set` names its limbs as standard34 does. The hips stay where a marker is missing
// from a whole observation: without them there is no reference frame. The body's size is known.
std::vector<Condition> HardConditions(const core::MarkerSet& set);

}  // namespace motiondb::tests
