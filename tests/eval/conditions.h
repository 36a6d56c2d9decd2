// Degraded observations: the same motion from a worse sensor or another source. Random choices are
// seeded by the clip's name, so every run and method gets the same observations.
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

// The first condition is clean. The others: markers missing at random, a limb missing, noise, other
// frame rates. `set` names its limbs as standard34 does. Whole observations keep their hips, which
// define the reference frame. The size of the body is known.
std::vector<Condition> HardConditions(const core::MarkerSet& set);

}  // namespace motiondb::tests
