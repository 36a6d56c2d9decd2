#include "tests/support/plan_goals.h"

#include <cmath>
#include <numbers>

#include "core/planning/seeded.h"

namespace motiondb::tests {

std::vector<core::FloorPose> RandomGoals(int count, unsigned seed) {
  core::SeededSequence random(seed);
  std::vector<core::FloorPose> goals;
  for (int i = 0; i < count; ++i) {
    const double distance = 1 + 3 * random.Next();
    const double bearing = std::numbers::pi * (random.Next() - 0.5);
    goals.push_back({distance * std::cos(bearing), distance * std::sin(bearing),
                     bearing + std::numbers::pi * (random.Next() - 0.5)});
  }
  return goals;
}

}  // namespace motiondb::tests
