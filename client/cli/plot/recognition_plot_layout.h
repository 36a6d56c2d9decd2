// Parts that both plots of a recognition share: windows, time axis, title, legend, labels and their
// colours. Coordinates and sizes are pixels, y downwards.
#pragma once

#include <motiondb/messages.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "client/cli/plot/picture.h"

namespace motiondb::v1 {
class RecognitionWindow;
}  // namespace motiondb::v1

namespace motiondb::client {

// The time interval of a window in the plot (s): around its middle, half way to its neighbours.
struct WindowCell {
  double start = 0;
  double middle = 0;
  double end = 0;
};

// The windows of a response with valid times.
struct PlotWindows {
  std::vector<const v1::RecognitionWindow*> windows;  // of the response, which must outlive this
  std::vector<WindowCell> cells;                      // one for each window
};

PlotWindows PlotWindowsOf(const v1::RecognizeResponse& response);

// Returns "31 windows of 0.4 s, every 0.1 s". `window_seconds`: width of the first window.
std::string WindowsText(const std::vector<WindowCell>& cells, double window_seconds);

// The time axis of the plot.
class TimeAxis {
 public:
  // Extends the axis to a cell.
  void Add(const WindowCell& cell);

  double X(const PictureFrame& frame, double seconds) const;
  std::vector<Tick> Ticks(const PictureFrame& frame) const;

 private:
  double start_ = 0;
  double end_ = 0;
  bool is_empty_ = true;
};

constexpr double kPlotLeft = 80;
constexpr double kPlotWidth = 854;  // of the frames
constexpr double kLegendGap = 44;   // between entries; many fonts are wider than estimated

// Returns "WHAT: FILE in DATABASE", each name cut to a width.
std::string PlotTitle(const std::string& what, const v1::RecognizeRequest& request);

// Completes a picture whose body ends at y = `bottom`: title, time axis, legends, size, and styles
// of labels.
void FinishPlot(Canvas& canvas, const std::string& title, const TimeAxis& time_axis, double bottom,
                const std::vector<std::vector<LegendEntry>>& legends);

// A label and what it is sorted by for its colour. The colours are those of Okabe and Ito, which
// are safe for colour blindness, except yellow. Further labels have the same colours: lines are
// dashed, areas have dots, then stripes.
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
