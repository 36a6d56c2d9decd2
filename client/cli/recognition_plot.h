// Generation probabilities of an observation over time, as in the paper's Figs. 13-15.
#pragma once

#include <motiondb/messages.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace motiondb::client {

// The time interval of a window in the plot (s): around its middle, half way to its neighbours.
struct WindowCell {
  double start = 0;
  double middle = 0;
  double end = 0;
};

// The log probabilities of a stored clip. A missing value or one that is not finite is -Infinity.
struct ClipProfile {
  std::string clip;  // short name
  std::string label;
  std::vector<double> log_probability;  // one for each window
};

struct LayerProfile {
  int layer = 0;
  double window_seconds = 0;  // width of the first window
  std::vector<WindowCell> windows;
  std::vector<ClipProfile> clips;  // in order of name
  // One for each window; nullopt if no clip has a path.
  std::vector<std::optional<std::string>> winners;
};

// Converts a response. Omits windows with invalid times.
LayerProfile LayerProfileFrom(const v1::RecognizeResponse& response);

// A label of the plot. Labels have the colours of Okabe and Ito, which are safe for colour
// blindness, except yellow; further labels have the same colours, dashed.
struct PlotLabel {
  std::string name;
  int clip_count = 0;
  int windows_won = 0;  // in all layers
};

// Returns all labels of clips and winners. Up to the number of colours they are sorted by name, so
// that all plots of a database use the same colours. More labels are sorted by the windows that
// they win, so that the most frequent ones have different colours.
std::vector<PlotLabel> PlotLabels(const std::vector<LayerProfile>& layers);

// Returns the indices of the labels.
std::map<std::string, int> LabelIndices(const std::vector<PlotLabel>& labels);

// Style names of the label with index `place`: for lines, areas, and text on areas; and their style
// sheet.
std::string LabelLineStyle(int place);
std::string LabelAreaStyle(int place);
std::string LabelTextStyle(int place);
std::string LabelStyleSheet();

// Returns the layers of the panels besides the bottom layer: a middle and an upper one, if the tree
// has them below the root.
std::vector<int> PlottedLayers(int bottom_layer);

// Returns a self-contained SVG file with a panel for each response. A panel shows the log
// generation probability of every stored clip at the middle of each window, coloured by label, and
// below them the label that wins the window. All panels have the same axes. Values that are not
// finite are omitted and counted. `request` is the request of the first layer; layer 0 is the
// bottom layer. The output is deterministic.
std::string RecognitionPlotSvg(const v1::RecognizeRequest& request,
                               const std::vector<v1::RecognizeResponse>& layers);

}  // namespace motiondb::client
