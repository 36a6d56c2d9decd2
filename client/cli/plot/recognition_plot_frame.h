// Parts that both plots of a recognition share: windows, time axis, title, legend. Coordinates and
// sizes are pixels, y downwards.
#pragma once

#include <motiondb/messages.h>

#include <cstddef>
#include <string>
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

}  // namespace motiondb::client
