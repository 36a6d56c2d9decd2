// The answer of a recognition over time, as the plot shows it.
#pragma once

#include <motiondb/messages.h>

#include <cstddef>
#include <string>
#include <vector>

#include "client/cli/plot/recognition_plot_layout.h"

namespace motiondb::client {

// A window, or the mean of adjacent windows of a long motion.
struct AnswerColumn {
  static constexpr int kNone = -1;
  static constexpr int kUnknown = -2;

  WindowCell cell;
  std::vector<double> probabilities;  // one for each label; with `unknown` at most 1 together
  double unknown = 0;
  double familiarity = 0;  // NaN if it is not finite
  int answer = kNone;      // kUnknown, or index of the most probable label
  int clip = kNone;        // index of the best clip
  std::string tooltip;
};

// A clip that is the best of any window.
struct AnswerClip {
  std::string name;  // short name
  int label = AnswerColumn::kNone;
  int windows_won = 0;
};

struct RecognitionAnswer {
  std::vector<WindowCell> windows;
  double window_seconds = 0;          // width of the first window
  std::vector<PlotLabel> labels;      // all, sorted for their colours
  std::vector<AnswerClip> clips;      // most windows first
  std::vector<AnswerColumn> columns;  // one for each window, or for `windows_per_column`
  std::size_t windows_per_column = 1;
  bool has_unknown = false;  // whether any window has the probability of unknown motion
  int unknown_windows = 0;   // windows with the answer "unknown"
};

// Converts a response. Omits windows with invalid times. Probabilities that are not finite are 0.
// The answer of a window is "unknown" if its probability is above `unknown_threshold`.
RecognitionAnswer RecognitionAnswerFrom(const v1::RecognizeResponse& response,
                                        double unknown_threshold);

}  // namespace motiondb::client
