// Synthetic motion files: a stick figure that walks, squats or waves.
#pragma once

#include <string>

namespace motiondb::tests {

enum class Act { kWalk, kSquat, kWave };

struct StickFigure {
  Act act = Act::kWalk;
  int frame_count = 60;
  double frame_rate_hz = 60;
  double phase = 0;    // of the movement, rad; distinguishes clips of one act
  double tempo = 1.0;  // cycles per second
};

// A walk of one second.
inline StickFigure Walk(double phase) {
  return {.act = Act::kWalk, .frame_count = 60, .phase = phase};
}

// Returns the motion as a BVH file in centimetres, y up: hips with six channels; legs, spine, head
// and arms with three rotations each.
std::string WriteBvh(const StickFigure& figure);

}  // namespace motiondb::tests
