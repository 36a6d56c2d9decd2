// What an observation looks like to a database over time, as in the paper's Figs. 13-15: profiles,
// labels, and the picture. Pure functions.
#pragma once

#include <motiondb/messages.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace motiondb::client {

// What Recognize answered, turned from windows into what is drawn: a profile over time for each
// stored clip, and the label that wins each window. Plain values; pure function.

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

// The labels of a picture of recognition and what they look like: colours that people with any
// colour vision can tell apart (those of Okabe and Ito, without the yellow that white swallows),
// and where there are more labels than colours, the same colours dashed. Pure functions.
struct PlotLabel {
  std::string name;
  int clip_count = 0;
  int windows_won = 0;  // in all layers
};

// All labels of the layers' clips and winners. As many as there are colours: in order of name, so
// that every picture of a database shows them alike. More: those that win most windows first, so
// that these differ in colour.
std::vector<PlotLabel> PlotLabels(const std::vector<LayerProfile>& layers);

// Their places in that order.
std::map<std::string, int> PlacesOf(const std::vector<PlotLabel>& labels);

// Styles for the label at a place, of a line, of an area and of text on that area, and the style
// sheet that they are in.
std::string LabelLineStyle(int place);
std::string LabelAreaStyle(int place);
std::string LabelTextStyle(int place);
std::string LabelStyleSheet();

// What an observation looks like to a database over time, as in the paper's Figs. 13-15. Pure
// function.

// The layers that are worth a panel beside the bottom layer: the middle one and an upper one, as
// far as the tree has them and they are not the root alone.
std::vector<int> LayersAbove(int bottom_layer);

// An SVG file that needs no other, with a panel for each answer of Recognize, one below the other:
// the log generation probability of every stored clip at the middle of each window, coloured by
// label, and below them the label that wins the window. All panels have the same axes; values that
// are not finite are left out, and the picture says so. `request` is what was asked of the layer on
// top; where it names no layer, that is the bottom layer of the tree. The same messages make the
// same bytes.
std::string RecognitionPlotSvg(const v1::RecognizeRequest& request,
                               const std::vector<v1::RecognizeResponse>& layers);

}  // namespace motiondb::client
