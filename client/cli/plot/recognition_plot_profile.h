// Generation probabilities of an observation over time, as in the paper's Figs. 13-15.
#pragma once

#include <motiondb/messages.h>

#include <optional>
#include <string>
#include <vector>

#include "client/cli/plot/canvas.h"
#include "client/cli/plot/recognition_plot_layout.h"

namespace motiondb::client {

// The log probabilities of a stored clip. A missing value or one that is not finite is -Infinity.
struct ClipProfile {
  std::string clip;  // short name
  std::string label;
  std::vector<double> log_probability;  // one for each window
  int windows_best = 0;                 // where it is the best clip
  int windows_near = 0;                 // where it is among the best three
  bool is_line = true;                  // else part of the grey band
};

struct LayerProfile {
  int layer = 0;
  double window_seconds = 0;  // width of the first window
  std::vector<WindowCell> windows;
  std::vector<ClipProfile> clips;  // in order of name
  // One for each window; nullopt if no clip has a path.
  std::vector<std::optional<std::string>> winners;
};

// Converts a response. Omits windows with invalid times. Up to 24 clips all are lines. Of more, at
// most 20 that are the best of a window are lines; if these are fewer than 12, also clips that are
// among the best three. Clips that are best in more windows come first.
LayerProfile LayerProfileFrom(const v1::RecognizeResponse& response);

// Returns all labels of clips and winners, sorted for their colours.
std::vector<PlotLabel> ProfileLabels(const std::vector<LayerProfile>& layers);

// Returns the layers of the panels besides the bottom layer: a middle and an upper one, if the tree
// has them below the root.
std::vector<int> PlottedLayers(int bottom_layer);

// Returns a picture with a panel for each response. A panel shows the log
// generation probability of stored clips at the middle of each window, coloured by label, a grey
// band from the 5 % to the 95 % quantile of the other clips, and below them the label that wins the
// window. All panels have the same axes. Values that are not finite are omitted and counted.
// `request` is the request of the first layer; layer 0 is the bottom layer.
Canvas ProfilePicture(const v1::RecognizeRequest& request,
                      const std::vector<v1::RecognizeResponse>& layers);

}  // namespace motiondb::client
