#include "client/cli/plot/recognition_plot_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_labels.h"

namespace motiondb::client {
namespace {

struct Point {
  double x = 0;
  double y = 0;
};

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

std::string PathData(const std::vector<Point>& points) {
  std::string data;
  for (const Point& point : points) {
    data +=
        fmt::format("{}{} {}", data.empty() ? "M" : "L", SvgNumber(point.x), SvgNumber(point.y));
  }
  return data;
}

std::string ProfileSvg(const ClipProfile& clip, const std::vector<WindowCell>& windows,
                       const Panel& panel, const std::string& style) {
  std::string data;
  std::vector<Point> points;
  for (std::size_t i = 0; i <= windows.size(); ++i) {
    if (i < windows.size() && std::isfinite(clip.log_probability[i])) {
      points.push_back({panel.X(windows[i].middle), panel.Y(clip.log_probability[i])});
    } else if (!points.empty()) {
      const WindowCell& first = windows[i - points.size()];
      data += PathData(PiecePoints(std::move(points), first, panel));
      points.clear();
    }
  }
  if (data.empty()) return "";
  return fmt::format("<path class=\"{}\" d=\"{}\"><title>{} ({})</title></path>\n", style, data,
                     SvgText(clip.clip), SvgText(clip.label));
}

// Returns the mean height of a clip's line, 1 for gaps. The most probable clips are drawn last.
double MeanFraction(const ClipProfile& clip, const LogProbabilityAxis& axis) {
  double sum = 0;
  for (const double value : clip.log_probability) {
    sum += std::isfinite(value) ? axis.Fraction(value) : 1;
  }
  return sum / static_cast<double>(clip.log_probability.size());
}

// Returns the band of the clips that are not lines, from their 5 % to their 95 % quantile.
std::string BandSvg(const LayerProfile& layer, const Panel& panel) {
  constexpr double kLow = 0.05, kHigh = 0.95;
  std::string data;
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
      data += PathData(outline) + "Z";
      upper.clear();
      lower.clear();
    }
  }
  if (data.empty()) return "";
  return fmt::format("<path class=\"band\" d=\"{}\"/>\n", data);
}

std::string ProfilesSvg(const LayerProfile& layer, const PanelAxes& axes, const Panel& panel) {
  std::vector<std::tuple<bool, double, const ClipProfile*>> clips;
  for (const ClipProfile& clip : layer.clips) {
    if (!clip.is_line) continue;
    clips.emplace_back(clip.windows_best > 0, -MeanFraction(clip, axes.log_probability), &clip);
  }
  // Comparing pointers is deterministic: they point into one vector.
  std::sort(clips.begin(), clips.end());
  std::string svg = BandSvg(layer, panel);
  for (const auto& [best, height, clip] : clips) {
    svg += ProfileSvg(*clip, layer.windows, panel,
                      fmt::format("clip {}{}", best ? "best " : "",
                                  LabelLineStyle(axes.label_indices.at(clip->label))));
  }
  return svg;
}

// Consecutive windows with the same winner are one area, with its name if it fits.
std::string WinnersSvg(const LayerProfile& layer, const PanelAxes& axes, const Panel& panel,
                       double top) {
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
  return StripSvg("winner", parts, top, kStripHeight);
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

std::string PanelSvg(const LayerProfile& layer, const std::string& title, const PanelAxes& axes,
                     const PictureFrame& frame) {
  constexpr double kMinTickDistance = 17;
  const Panel panel(axes, frame);
  std::vector<Tick> y_ticks;
  for (const double value : axes.log_probability.Ticks(kMinTickDistance / frame.height)) {
    y_ticks.push_back({panel.Y(value), LogProbabilityAxis::TickText(value)});
  }
  const std::string clip_path = fmt::format("panel-{}", SvgNumber(frame.top));
  std::string svg = SvgLabel("panel-title", frame.left, frame.top - 8, title) +
                    SvgLabel("tick", frame.right(), frame.top - 8,
                             LeftOutText(layer, axes.log_probability), "text-anchor=\"end\"");
  svg += GridSvg(frame, axes.time.Ticks(frame), y_ticks) + YTicksSvg(frame, y_ticks) +
         YCaptionSvg(frame, "log probability");
  const std::string profiles = ProfilesSvg(layer, axes, panel);
  svg += ClipPathSvg(clip_path, frame) +
         fmt::format("<g clip-path=\"url(#{})\">\n{}</g>\n", clip_path, profiles);
  if (profiles.empty()) {
    svg += SvgLabel("line", frame.left + frame.width / 2, frame.top + frame.height / 2,
                    NothingText(layer), "text-anchor=\"middle\"");
  }
  return svg + FrameSvg(frame) + WinnersSvg(layer, axes, panel, frame.bottom() + kStripGap);
}

std::string PanelStyleSheet(const LayerProfile& layer) {
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
  return fmt::format(
      "\n"
      "    .panel-title {{ font-size: 14px; font-weight: bold; fill: #333; }}\n"
      "    .clip {{ fill: none; stroke-width: {}; stroke-opacity: {}; stroke-linejoin: round; }}\n"
      "    .best {{ stroke-width: {}; stroke-opacity: {}; }}\n"
      "    .clip:hover {{ stroke-width: 3.5; stroke-opacity: 1; }}\n"
      "    .band {{ fill: #e2e2e2; stroke: #d0d0d0; stroke-width: 1; }}\n"
      "    .winner-name {{ font-size: 12px; }}\n"
      "    .sample {{ stroke-width: 3; }}\n",
      line.width, line.opacity, best.width, best.opacity);
}

}  // namespace motiondb::client
