// Labels of the plots of a recognition, and their colours: those of Okabe and Ito, which are safe
// for colour blindness, except yellow. Further labels have the same colours: lines are dashed,
// areas have dots, then stripes.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "client/cli/plot/picture.h"

namespace motiondb::client {

struct PlotLabel {
  std::string name;
  int clip_count = 0;
  int windows_won = 0;
  double probability = 0;  // sum over the windows
  int line_count = 0;      // of its clips, in all layers
};

// Returns the labels of a map from names, sorted for their colours. Up to the number of colours
// they are sorted by name, so that all plots of a database use the same colours. More labels are
// sorted by windows won, probability, lines and clips, so that the most frequent ones have
// different colours.
std::vector<PlotLabel> SortedLabels(const std::map<std::string, PlotLabel>& by_name);

// Returns the indices of the labels.
std::map<std::string, int> LabelIndices(const std::vector<PlotLabel>& labels);

// Number of different styles of labels. Labels after these repeat them.
constexpr int kLabelStyles = 24;

// Style names of the label with index `place`: for lines, areas, and text on areas.
std::string LabelLineStyle(int place);
std::string LabelAreaStyle(int place);
std::string LabelTextStyle(int place);
std::string LabelPlateStyle(int place);  // of a plate below the text; "" if it needs none
void AddLabelStyles(Canvas& canvas);

// A stretch of a strip with one colour, and its name if it fits.
struct StripPart {
  double left = 0;
  double width = 0;
  std::string area_style;
  std::string text_style;
  std::string plate_style;  // may be empty
  std::string text;
  std::string tooltip;  // may be empty
};

// Returns whether the name of a part fits in it.
bool NameFits(std::string_view text, double width);

// Returns the name, cut to the width if a recognizable part of it fits; otherwise all of it.
std::string FittingName(const std::string& name, double width);

// Draws a strip at y = `top`. `kind`: style name of the areas; that of names is "KIND-name".
void DrawStrip(Canvas& canvas, std::string_view kind, const std::vector<StripPart>& parts,
               double top, double height);

}  // namespace motiondb::client
