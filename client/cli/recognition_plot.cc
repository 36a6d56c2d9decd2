#include "client/cli/recognition_plot.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "client/cli/database_text.h"
#include "client/cli/picture.h"
#include "client/cli/print.h"
#include "client/cli/recognition_plot_panel.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {

namespace {

bool HasValidTimes(const v1::RecognitionWindow& window) {
  constexpr double kMaxSeconds = 1e8;
  return window.start_seconds() >= 0 && window.start_seconds() <= window.end_seconds() &&
         window.end_seconds() <= kMaxSeconds;
}

std::vector<WindowCell> Cells(const std::vector<const v1::RecognitionWindow*>& windows) {
  std::vector<WindowCell> cells;
  for (const v1::RecognitionWindow* window : windows) {
    cells.push_back({window->start_seconds(), (window->start_seconds() + window->end_seconds()) / 2,
                     window->end_seconds()});
  }
  const std::size_t count = cells.size();
  for (std::size_t i = 0; i + 1 < count; ++i) {
    cells[i].end = cells[i + 1].start = (cells[i].middle + cells[i + 1].middle) / 2;
  }
  if (count > 1) {  // first and last are symmetric; a single window keeps its own times
    cells.front().start = 2 * cells.front().middle - cells.front().end;
    cells.back().end = 2 * cells.back().middle - cells.back().start;
  }
  return cells;
}

}  // namespace

LayerProfile LayerProfileFrom(const v1::RecognizeResponse& response) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::vector<const v1::RecognitionWindow*> windows;
  for (const v1::RecognitionWindow& window : response.windows()) {
    if (HasValidTimes(window)) windows.push_back(&window);
  }
  LayerProfile profile;
  if (windows.empty()) return profile;
  profile.layer = windows.front()->layer();
  profile.window_seconds = windows.front()->end_seconds() - windows.front()->start_seconds();
  profile.windows = Cells(windows);
  std::map<std::string, ClipProfile> clips;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    bool explained = false;
    for (const v1::ClipProbability& clip : windows[i]->clips()) {
      ClipProfile& drawn = clips[clip.clip()];
      if (drawn.log_probability.empty()) {
        drawn.clip = ShortName(clip.clip());
        drawn.label = LabelOrPlaceholder(clip.label());
        drawn.log_probability.assign(windows.size(), kNone);
      }
      if (!std::isfinite(clip.log_probability())) continue;
      drawn.log_probability[i] = clip.log_probability();
      explained = true;
    }
    // If no clip has a path, all labels are equal, and none wins.
    profile.winners.emplace_back();
    if (explained && windows[i]->labels_size() > 0) {
      profile.winners.back() = LabelOrPlaceholder(windows[i]->labels(0).label());
    }
  }
  for (auto& [name, clip] : clips) profile.clips.push_back(std::move(clip));
  return profile;
}

namespace {

struct Colour {
  const char* code;
  const char* text;  // colour of text on it
};

constexpr Colour kColours[] = {
    {"#0072b2", "#fff"}, {"#d55e00", "#fff"}, {"#009e73", "#fff"}, {"#cc79a7", "#222"},
    {"#e69f00", "#222"}, {"#56b4e9", "#222"}, {"#222222", "#fff"}, {"#999999", "#222"},
};
constexpr int kColourCount = static_cast<int>(std::size(kColours));

constexpr const char* kDashes[] = {"", "6 3", "2 2"};
constexpr int kDashCount = static_cast<int>(std::size(kDashes));

}  // namespace

std::vector<PlotLabel> PlotLabels(const std::vector<LayerProfile>& layers) {
  std::map<std::string, PlotLabel> found;
  for (const LayerProfile& layer : layers) {
    std::map<std::string, int> clip_counts;
    for (const ClipProfile& clip : layer.clips) ++clip_counts[clip.label];
    // All layers have the same clips, unless the model was replaced between the queries.
    for (const auto& [label, count] : clip_counts) {
      found[label].clip_count = std::max(found[label].clip_count, count);
    }
    for (const auto& winner : layer.winners) {
      if (winner) ++found[*winner].windows_won;
    }
  }
  std::vector<PlotLabel> labels;
  for (auto& [name, label] : found) {
    label.name = name;
    labels.push_back(label);
  }
  if (static_cast<int>(labels.size()) > kColourCount) {
    std::stable_sort(labels.begin(), labels.end(), [](const PlotLabel& a, const PlotLabel& b) {
      return std::tie(a.windows_won, a.clip_count) > std::tie(b.windows_won, b.clip_count);
    });
  }
  return labels;
}

std::map<std::string, int> LabelIndices(const std::vector<PlotLabel>& labels) {
  std::map<std::string, int> places;
  for (const PlotLabel& label : labels) places.emplace(label.name, static_cast<int>(places.size()));
  return places;
}

std::string LabelLineStyle(int place) {
  const int dash = place / kColourCount % kDashCount;
  return fmt::format("c{}{}", place % kColourCount, dash > 0 ? fmt::format(" d{}", dash) : "");
}

std::string LabelAreaStyle(int place) { return fmt::format("a{}", place % kColourCount); }

std::string LabelTextStyle(int place) { return fmt::format("t{}", place % kColourCount); }

std::string LabelStyleSheet() {
  std::string sheet;
  for (int i = 0; i < kColourCount; ++i) {
    sheet +=
        fmt::format("    .c{0} {{ stroke: {1}; }} .a{0} {{ fill: {1}; }} .t{0} {{ fill: {2}; }}\n",
                    i, kColours[i].code, kColours[i].text);
  }
  for (int i = 1; i < kDashCount; ++i) {
    sheet += fmt::format("    .d{} {{ stroke-dasharray: {}; }}\n", i, kDashes[i]);
  }
  return sheet;
}

namespace {

constexpr double kPanelLeft = 80, kPanelRight = 26, kPanelWidth = 854;
constexpr double kBetweenPanels = 14;
constexpr double kBelowPanels = 66;  // for the time axis
constexpr double kBelowLegend = 24, kBetweenLegendEntries = 34;

PanelAxes AxesOf(const std::vector<LayerProfile>& layers, const std::vector<PlotLabel>& labels) {
  constexpr double kMinSeconds = 0.01;
  PanelAxes axes;
  axes.label_indices = LabelIndices(labels);
  bool first = true;
  for (const LayerProfile& layer : layers) {
    for (const WindowCell& window : layer.windows) {
      axes.start_seconds = first ? window.start : std::min(axes.start_seconds, window.start);
      axes.end_seconds = first ? window.end : std::max(axes.end_seconds, window.end);
      first = false;
    }
    for (const ClipProfile& clip : layer.clips) {
      for (const double value : clip.log_probability) axes.log_probability.Add(value);
    }
  }
  axes.end_seconds = std::max(axes.end_seconds, axes.start_seconds + kMinSeconds);
  return axes;
}

std::string WindowsText(const LayerProfile& layer) {
  if (layer.windows.empty()) return "no windows";
  if (layer.windows.size() == 1) return fmt::format("one window of {:.3g} s", layer.window_seconds);
  const double hop = (layer.windows.back().middle - layer.windows.front().middle) /
                     static_cast<double>(layer.windows.size() - 1);
  return fmt::format("{} windows of {:.3g} s, every {:.3g} s", layer.windows.size(),
                     layer.window_seconds, hop);
}

std::vector<std::string> HeadingLines(const v1::RecognizeRequest& request,
                                      const LayerProfile& layer, std::size_t label_count) {
  std::string what =
      fmt::format("{}; {} of {}; only the tree and its graphs", WindowsText(layer),
                  CountText(layer.clips.size(), "stored clip"), CountText(label_count, "label"));
  if (request.generation() == v1::GENERATION_TOP_PATHS) {
    constexpr int kDefaultPaths = 5;  // from the wire contract
    const int paths = request.path_count() > 0 ? request.path_count() : kDefaultPaths;
    what += fmt::format(", best {}", CountText(paths, "path"));
  }
  return {what,
          "Natural logarithm, nearly linear to -10. Thick lines: best clips of a window. Strips: "
          "winning labels."};
}

std::string PanelTitle(const LayerProfile& layer, bool bottom) {
  if (layer.windows.empty()) return bottom ? "Bottom layer" : "";
  return fmt::format("Layer {}{}", layer.layer, bottom ? ", the bottom of the tree" : "");
}

std::vector<LegendEntry> LegendOf(const std::vector<PlotLabel>& labels) {
  constexpr std::size_t kMaxEntries = 24;
  constexpr double kNameWidth = 190;
  std::vector<LegendEntry> entries;
  for (std::size_t i = 0; i < std::min(labels.size(), kMaxEntries); ++i) {
    const std::string style = "sample " + LabelLineStyle(static_cast<int>(i));
    entries.push_back({fmt::format("{}: {}", TruncateToWidth(labels[i].name, kNameWidth),
                                   CountText(labels[i].clip_count, "clip")),
                       [style](double x, double y) { return SvgLine(style, x, y, x + 20, y); }});
  }
  if (labels.size() > kMaxEntries) {
    entries.push_back({fmt::format("and {} more", labels.size() - kMaxEntries),
                       [](double, double) { return std::string(); }});
  }
  return entries;
}

}  // namespace

std::vector<int> PlottedLayers(int bottom_layer) {
  std::vector<int> layers;
  int below = bottom_layer;
  for (const int layer : {(bottom_layer + 1) / 2, std::max(2, bottom_layer / 4)}) {
    if (layer < 2 || layer >= below) continue;
    layers.push_back(layer);
    below = layer;
  }
  return layers;
}

std::string RecognitionPlotSvg(const v1::RecognizeRequest& request,
                               const std::vector<v1::RecognizeResponse>& responses) {
  constexpr double kTitleNameWidth = 230;
  std::vector<LayerProfile> layers;
  for (const v1::RecognizeResponse& response : responses)
    layers.push_back(LayerProfileFrom(response));
  if (layers.empty()) layers.emplace_back();
  const std::vector<PlotLabel> labels = PlotLabels(layers);
  const PanelAxes axes = AxesOf(layers, labels);
  const std::string title =
      fmt::format("Generation probability: {} in {}",
                  TruncateToWidth(request.observation().file().file_name(), kTitleNameWidth),
                  TruncateToWidth(ShortName(request.database()), kTitleNameWidth));
  const std::vector<std::string> lines = HeadingLines(request, layers.front(), labels.size());

  std::string body = HeadingSvg(kPanelLeft, kPanelWidth, title, lines);
  PictureFrame frame{kPanelLeft, HeadingHeight(lines.size()) + kPanelTitleHeight, kPanelWidth,
                     kPanelFrameHeight};
  double bottom = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    body += PanelSvg(layers[i], PanelTitle(layers[i], i == 0 && request.layer() == 0), axes, frame);
    bottom = frame.bottom() + kStripGap + kStripHeight;
    frame.top += kPanelHeight + kBetweenPanels;
  }
  body += XTicksSvg(bottom, TimeTicks(axes, frame)) +
          XCaptionSvg(frame, bottom, "middle of the window (s)");
  const Legend legend =
      LegendSvg(LegendOf(labels), kPanelLeft, kPanelLeft + kPanelWidth + kPanelRight,
                bottom + kBelowPanels, kBetweenLegendEntries);
  const double width = kPanelLeft + kPanelWidth + kPanelRight;
  const double height = legend.last_y + kBelowLegend;
  return PictureHead(width, height, title, PanelStyleSheet(layers.front()) + LabelStyleSheet()) +
         BackgroundSvg(width, height) + body + legend.svg + "</svg>\n";
}

}  // namespace motiondb::client
