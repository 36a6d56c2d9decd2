#include "client/cli/plot/recognition_plot_frame.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>

#include "client/cli/plot/recognition_plot_labels.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

bool HasValidTimes(const v1::RecognitionWindow& window) {
  constexpr double kMaxSeconds = 1e8;
  return window.start_seconds() >= 0 && window.start_seconds() <= window.end_seconds() &&
         window.end_seconds() <= kMaxSeconds;
}

}  // namespace

PlotWindows PlotWindowsOf(const v1::RecognizeResponse& response) {
  PlotWindows drawn;
  std::vector<WindowCell>& cells = drawn.cells;
  for (const v1::RecognitionWindow& window : response.windows()) {
    if (!HasValidTimes(window)) continue;
    drawn.windows.push_back(&window);
    cells.push_back({window.start_seconds(), (window.start_seconds() + window.end_seconds()) / 2,
                     window.end_seconds()});
  }
  const std::size_t count = cells.size();
  for (std::size_t i = 0; i + 1 < count; ++i) {
    cells[i].end = cells[i + 1].start = (cells[i].middle + cells[i + 1].middle) / 2;
  }
  if (count > 1) {  // first and last are symmetric; a single window keeps its own times
    cells.front().start = 2 * cells.front().middle - cells.front().end;
    cells.back().end = 2 * cells.back().middle - cells.back().start;
  }
  return drawn;
}

std::string WindowsText(const std::vector<WindowCell>& cells, double window_seconds) {
  if (cells.empty()) return "no windows";
  if (cells.size() == 1) return fmt::format("one window of {:.3g} s", window_seconds);
  const double hop =
      (cells.back().middle - cells.front().middle) / static_cast<double>(cells.size() - 1);
  return fmt::format("{} windows of {:.3g} s, every {:.3g} s", cells.size(), window_seconds, hop);
}

void TimeAxis::Add(const WindowCell& cell) {
  start_ = is_empty_ ? cell.start : std::min(start_, cell.start);
  end_ = is_empty_ ? cell.end : std::max(end_, cell.end);
  is_empty_ = false;
}

namespace {

double SpanSeconds(bool is_empty, double start, double end) {
  constexpr double kMinSeconds = 0.01;
  return is_empty ? 1 : std::max(end - start, kMinSeconds);
}

}  // namespace

double TimeAxis::X(const PictureFrame& frame, double seconds) const {
  return frame.left + frame.width * (seconds - start_) / SpanSeconds(is_empty_, start_, end_);
}

std::vector<Tick> TimeAxis::Ticks(const PictureFrame& frame) const {
  const double span = SpanSeconds(is_empty_, start_, end_);
  return LinearTicks(start_, start_ + span, TickStep(frame.width / span),
                     [&](double seconds) { return X(frame, seconds); });
}

std::string PlotTitle(const std::string& what, const v1::RecognizeRequest& request) {
  constexpr double kNameWidth = 230;
  return fmt::format("{}: {} in {}", what,
                     TruncateToWidth(request.observation().file().file_name(), kNameWidth),
                     TruncateToWidth(ShortName(request.database()), kNameWidth));
}

void FinishPlot(Canvas& canvas, const std::string& title, const TimeAxis& time_axis, double bottom,
                const std::vector<std::vector<LegendEntry>>& legends) {
  constexpr double kRightMargin = 26, kBelowPlot = 66;  // below: the time axis
  constexpr double kBetweenLegends = 32, kBelowLegends = 24;
  const double width = kPlotLeft + kPlotWidth + kRightMargin;
  const PictureFrame frame{kPlotLeft, 0, kPlotWidth, bottom};
  DrawXTicks(canvas, bottom, time_axis.Ticks(frame));
  DrawXCaption(canvas, frame, bottom, "middle of the window (s)");
  double y = bottom + kBelowPlot;
  for (const std::vector<LegendEntry>& entries : legends) {
    if (entries.empty()) continue;
    y = DrawLegend(canvas, entries, kPlotLeft, width, y, kLegendGap) + kBetweenLegends;
  }
  canvas.SetTitle(title);
  canvas.SetSize(width, y - kBetweenLegends + kBelowLegends);
  AddLabelStyles(canvas);
}

}  // namespace motiondb::client
