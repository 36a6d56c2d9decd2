// The motion files of the simulated clients.
#pragma once

#include <string>
#include <vector>

#include "tests/support/stick_figure.h"

namespace motiondb::simulation {

inline constexpr int kMotions = 16;

// Short motions, so that models are built quickly. All seeds share them.
inline const std::string& Motion(int motion) {
  static const std::vector<std::string> motions = [] {
    std::vector<std::string> made;
    for (int i = 0; i < kMotions; ++i) {
      made.push_back(tests::WriteBvh({.act = i % 2 == 0 ? tests::Act::kWalk : tests::Act::kSquat,
                                      .frame_count = 8 + i,
                                      .phase = 0.4 * i}));
    }
    return made;
  }();
  return motions[static_cast<std::size_t>(motion)];
}

}  // namespace motiondb::simulation
