// Motion files that tests write themselves: a stick figure that walks, squats or waves.
#pragma once

#include <string>

namespace motiondb::tests {

enum class Act { kWalk, kSquat, kWave };

struct StickFigure {
  Act act = Act::kWalk;
  int frame_count = 60;
  double frame_rate_hz = 60;
  double phase = 0;    // of the movement, radians; also tells clips of one act apart
  double tempo = 1.0;  // cycles a second
};

// The motion as a BVH file in centimetres, y up: hips with six channels, then legs, spine, head and
// arms with three rotations each.
std::string WriteBvh(const StickFigure& figure);

}  // namespace motiondb::tests
