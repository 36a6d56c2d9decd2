// What a caller of inverse kinematics chooses. Plain values.
#pragma once

#include <vector>

namespace motiondb::core {

struct IkOptions {
  // Every angle stays within its joint's limits.
  bool respect_limits = true;
  // How much each marker's squared distance counts, not negative; empty: all alike. Only their
  // ratios matter. A body of other proportions than the markers' wants feet and pelvis to weigh
  // more than what lies between.
  std::vector<double> marker_weights = {};
  // Pull of each coordinate towards the frame before, in m^2: 1e-4 for one radian weighs as much as
  // a marker 1 cm off. Angles that the markers hardly tell, such as the twist of a straight arm,
  // then stay calm; those they tell well are not held back to speak of. It grows where the markers
  // cannot be met: twofold at 5 mm rms, a hundredfold at 5 cm. 0: none.
  double smoothness = 1e-4;
};

// How far a pose's markers are from where they should be (m), over the markers that are present,
// each counted alike.
struct IkError {
  double rms_m = 0;
  double largest_m = 0;
};

}  // namespace motiondb::core
