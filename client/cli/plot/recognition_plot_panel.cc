#include "client/cli/plot/recognition_plot_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_layout.h"

namespace motiondb::client {
namespace {

// Maps values to coordinates of a panel.
class Panel {
 public:
  Panel(const PanelAxes& axes, const PictureFrame& frame) : axes_(axes), frame_(frame) {}

  double X(double seconds) const { return axes_.time.X(frame_, seconds); }
  double Y(double log_probability) const {
    constexpr double kFarBelow = 2;  // frame heights; invisible, like all lower positions
    return frame_.top +
           frame_.height * std::min(axes_.log_probability.Fraction(log_probability), kFarBelow);
  }

 private:
  const PanelAxes& axes_;
  const PictureFrame& frame_;
};

// Keeps only the lowest and the highest point of each pixel column.
std::vector<Point> Thinned(const std::vector<Point>& points) {
  std::vector<Point> thinned;
  for (std::size_t begin = 0, end = 0; begin < points.size(); begin = end) {
    const double column = std::floor(points[begin].x);
    std::size_t low = begin, high = begin;
    for (end = begin; end < points.size() && std::floor(points[end].x) == column; ++end) {
      if (points[end].y < points[low].y) low = end;
      if (points[end].y > points[high].y) high = end;
    }
    thinned.push_back(points[std::min(low, high)]);
    if (low != high) thinned.push_back(points[std::max(low, high)]);
  }
  return thinned;
}

// Points of consecutive windows; a single window gives a dash over its interval.
std::vector<Point> PiecePoints(std::vector<Point> points, const WindowCell& first,
                               const Panel& panel) {
  if (points.size() > 1) return Thinned(points);
  return {{panel.X(first.start), points[0].y}, {panel.X(first.end), points[0].y}};
}

void DrawProfile(Canvas& canvas, const ClipProfile& clip, const std::vector<WindowCell>& windows,
                 const Panel& panel, const std::string& style) {
  std::vector<Outline> lines;
  std::vector<Point> points;
  for (std::size_t i = 0; i <= windows.size(); ++i) {
    if (i < windows.size() && std::isfinite(clip.log_probability[i])) {
      points.push_back({panel.X(windows[i].middle), panel.Y(clip.log_probability[i])});
    } else if (!points.empty()) {
      const WindowCell& first = windows[i - points.size()];
      lines.push_back({PiecePoints(std::move(points), first, panel), false});
      points.clear();
    }
  }
  if (lines.empty()) return;
  canvas.Path(style, std::move(lines)).tooltip = fmt::format("{} ({})", clip.clip, clip.label);
}

// Returns the mean height of a clip's line, 1 for gaps. The most probable clips are drawn last.
double MeanFraction(const ClipProfile& clip, const LogProbabilityAxis& axis) {
  double sum = 0;
  for (const double value : clip.log_probability) {
    sum += std::isfinite(value) ? axis.Fraction(value) : 1;
  }
  return sum / static_cast<double>(clip.log_probability.size());
}

// Draws the band of the clips that are not lines, from their 5 % to their 95 % quantile.
void DrawBand(Canvas& canvas, const LayerProfile& layer, const Panel& panel) {
  constexpr double kLow = 0.05, kHigh = 0.95;
  std::vector<Outline> band;
  std::vector<Point> upper, lower;
  std::vector<double> values;
  for (std::size_t i = 0; i <= layer.windows.size(); ++i) {
    values.clear();
    for (std::size_t c = 0; i < layer.windows.size() && c < layer.clips.size(); ++c) {
      const ClipProfile& clip = layer.clips[c];
      if (!clip.is_line && std::isfinite(clip.log_probability[i])) {
        values.push_back(clip.log_probability[i]);
      }
    }
    if (!values.empty()) {
      std::sort(values.begin(), values.end());
      const auto last = static_cast<double>(values.size() - 1);
      const double x = panel.X(layer.windows[i].middle);
      upper.push_back({x, panel.Y(values[static_cast<std::size_t>(std::ceil(kHigh * last))])});
      lower.push_back({x, panel.Y(values[static_cast<std::size_t>(std::floor(kLow * last))])});
    } else if (!upper.empty()) {
      const WindowCell& first = layer.windows[i - upper.size()];
      std::vector<Point> outline = PiecePoints(std::move(upper), first, panel);
      const std::vector<Point> back = PiecePoints(std::move(lower), first, panel);
      outline.insert(outline.end(), back.rbegin(), back.rend());
      band.push_back({std::move(outline), true});
      upper.clear();
      lower.clear();
    }
  }
  if (!band.empty()) canvas.Path("band", std::move(band));
}

void DrawProfiles(Canvas& canvas, const LayerProfile& layer, const PanelAxes& axes,
                  const Panel& panel) {
  std::vector<std::tuple<bool, double, const ClipProfile*>> clips;
  for (const ClipProfile& clip : layer.clips) {
    if (!clip.is_line) continue;
    clips.emplace_back(clip.windows_best > 0, -MeanFraction(clip, axes.log_probability), &clip);
  }
  // Comparing pointers is deterministic: they point into one vector.
  std::sort(clips.begin(), clips.end());
  DrawBand(canvas, layer, panel);
  for (const auto& [best, height, clip] : clips) {
    DrawProfile(canvas, *clip, layer.windows, panel,
                fmt::format("clip {}{}", best ? "best " : "",
                            LabelLineStyle(axes.label_indices.at(clip->label))));
  }
}

// Consecutive windows with the same winner are one area, with its name if it fits.
void DrawWinners(Canvas& canvas, const LayerProfile& layer, const PanelAxes& axes,
                 const Panel& panel, double top) {
  std::vector<StripPart> parts;
  for (std::size_t begin = 0, end = 0; begin < layer.winners.size(); begin = end) {
    const auto& winner = layer.winners[begin];
    while (end < layer.winners.size() && layer.winners[end] == winner) ++end;
    if (!winner) continue;
    const int place = axes.label_indices.at(*winner);
    const double left = panel.X(layer.windows[begin].start);
    parts.push_back({left, panel.X(layer.windows[end - 1].end) - left, LabelAreaStyle(place),
                     LabelTextStyle(place), LabelPlateStyle(place), *winner,
                     fmt::format("{}, {:.2f}-{:.2f} s", *winner, layer.windows[begin].start,
                                 layer.windows[end - 1].end)});
  }
  DrawStrip(canvas, "winner", parts, top, kStripHeight);
}

// Returns the number of values that the panel does not show.
std::string LeftOutText(const LayerProfile& layer, const LogProbabilityAxis& axis) {
  std::size_t impossible = 0, below = 0, all = 0;
  for (const ClipProfile& clip : layer.clips) {
    for (const double value : clip.log_probability) {
      ++all;
      if (!std::isfinite(value)) {
        ++impossible;
      } else if (axis.IsBelow(value)) {
        ++below;
      }
    }
  }
  std::string text;
  if (impossible > 0) text = fmt::format("{} of {} values are -Infinity: no path", impossible, all);
  if (below > 0) {
    text += fmt::format("{}{} of {} lie below", text.empty() ? "" : "; ", below, all);
  }
  return text;
}

std::string NothingText(const LayerProfile& layer) {
  if (layer.windows.empty()) return "no windows";
  return layer.clips.empty() ? "no clips" : "no clip explains any window";
}

}  // namespace

void DrawPanel(Canvas& canvas, const LayerProfile& layer, const std::string& title,
               const PanelAxes& axes, const PictureFrame& frame) {
  constexpr double kMinTickDistance = 17;
  const Panel panel(axes, frame);
  std::vector<Tick> y_ticks;
  for (const double value : axes.log_probability.Ticks(kMinTickDistance / frame.height)) {
    y_ticks.push_back({panel.Y(value), LogProbabilityAxis::TickText(value)});
  }
  canvas.Label("panel-title", frame.left, frame.top - 8, title);
  canvas.Label("tick", frame.right(), frame.top - 8, LeftOutText(layer, axes.log_probability),
               Anchor::kEnd);
  DrawGrid(canvas, frame, axes.time.Ticks(frame), y_ticks);
  DrawYTicks(canvas, frame, y_ticks);
  DrawYCaption(canvas, frame, "log probability");
  canvas.BeginGroup(frame);
  const std::size_t before = canvas.shapes().size();
  DrawProfiles(canvas, layer, axes, panel);
  const bool is_empty = canvas.shapes().size() == before;
  canvas.EndGroup();
  if (is_empty) {
    canvas.Label("line", frame.left + frame.width / 2, frame.top + frame.height / 2,
                 NothingText(layer), Anchor::kMiddle);
  }
  canvas.Rectangle("frame", frame);
  DrawWinners(canvas, layer, axes, panel, frame.bottom() + kStripGap);
}

void AddPanelStyles(Canvas& canvas, const LayerProfile& layer) {
  constexpr std::size_t kFewClips = 30, kSomeClips = 120, kFewWindows = 150;
  struct Stroke {
    double width;
    double opacity;
  };
  const auto clips = static_cast<std::size_t>(std::count_if(
      layer.clips.begin(), layer.clips.end(), [](const auto& clip) { return clip.is_line; }));
  const Stroke line = clips <= kFewClips    ? Stroke{1.4, 0.85}
                      : clips <= kSomeClips ? Stroke{1.1, 0.65}
                                            : Stroke{0.9, 0.45};
  const Stroke best =
      layer.windows.size() <= kFewWindows ? Stroke{2, 1} : Stroke{1.2 * line.width, 0.9};
  canvas.AddStyle("panel-title", {.fill = "#333", .font_size = 14, .bold = true});
  canvas.AddStyle("clip", {.fill = "none",
                           .stroke_width = line.width,
                           .stroke_opacity = line.opacity,
                           .round = true,
                           .hover_width = 3.5});
  canvas.AddStyle("best", {.stroke_width = best.width, .stroke_opacity = best.opacity});
  canvas.AddStyle("band", {.fill = "#e2e2e2", .stroke = "#d0d0d0", .stroke_width = 1});
  canvas.AddStyle("winner-name", {.font_size = 12});
  canvas.AddStyle("sample", {.stroke_width = 3});
}

}  // namespace motiondb::client
