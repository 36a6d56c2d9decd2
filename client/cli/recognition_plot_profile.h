// What Recognize answered, turned from windows into what is drawn: a profile over time for each
// stored clip, and the label that wins each window. Plain values; pure function.
#pragma once

#include <motiondb/messages.h>

#include <optional>
#include <string>
#include <vector>

namespace motiondb::client {

// The time that a window stands for (s): around its middle, half way to its neighbours.
struct WindowCell {
  double start = 0;
  double middle = 0;
  double end = 0;
};

// One stored clip. Where it has no log probability, or one that is not finite, there is -Infinity.
struct ClipProfile {
  std::string clip;  // short name
  std::string label;
  std::vector<double> log_probability;  // one for each window
};

struct LayerProfile {
  int layer = 0;
  double window_seconds = 0;  // width of the first window
  std::vector<WindowCell> windows;
  std::vector<ClipProfile> clips;                   // in order of name
  std::vector<std::optional<std::string>> winners;  // one for each window; none if no clip fits
};

// Windows whose times make no sense are left out.
LayerProfile ProfileOf(const v1::RecognizeResponse& response);

}  // namespace motiondb::client
