// The labels of a picture of recognition and what they look like: colours that people with any
// colour vision can tell apart (those of Okabe and Ito, without the yellow that white swallows),
// and where there are more labels than colours, the same colours dashed. Pure functions.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "client/cli/recognition_plot_profile.h"

namespace motiondb::client {

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

}  // namespace motiondb::client
