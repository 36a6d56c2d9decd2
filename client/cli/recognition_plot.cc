#include "client/cli/recognition_plot.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>

#include "client/cli/count_text.h"
#include "client/cli/picture.h"
#include "client/cli/recognition_plot_labels.h"
#include "client/cli/recognition_plot_panel.h"
#include "client/cli/recognition_plot_profile.h"
#include "client/cli/resource_name.h"
#include "client/cli/svg.h"

namespace motiondb::client {
namespace {

constexpr double kLeft = 80, kRight = 26, kWidth = 854;  // of the panels
constexpr double kBetweenPanels = 14;
constexpr double kBelowPanels = 66;  // to the legend: the time axis
constexpr double kBelowLegend = 24, kBetweenLegendEntries = 34;

PanelAxes AxesOf(const std::vector<LayerProfile>& layers, const std::vector<PlotLabel>& labels) {
  constexpr double kLeastSeconds = 0.01;
  PanelAxes axes;
  axes.label_places = PlacesOf(labels);
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
  axes.end_seconds = std::max(axes.end_seconds, axes.start_seconds + kLeastSeconds);
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
      fmt::format("{}; {} of {}; by the tree and its graphs alone", WindowsText(layer),
                  CountText(layer.clips.size(), "stored clip"), CountText(label_count, "label"));
  if (request.generation() == v1::GENERATION_TOP_PATHS) {
    constexpr int kDefaultPaths = 5;  // the contract's
    const int paths = request.path_count() > 0 ? request.path_count() : kDefaultPaths;
    what += fmt::format(", best {}", CountText(paths, "path"));
  }
  return {what,
          "Natural logarithm, nearly linear to -10. Thick lines: clips that are the best of a "
          "window. Strips: the label that wins."};
}

std::string PanelTitle(const LayerProfile& layer, bool bottom) {
  if (layer.windows.empty()) return bottom ? "Bottom layer" : "";
  return fmt::format("Layer {}{}", layer.layer, bottom ? ", the bottom of the tree" : "");
}

std::vector<LegendEntry> LegendOf(const std::vector<PlotLabel>& labels) {
  constexpr std::size_t kMostEntries = 24;
  constexpr double kNameWidth = 190;
  std::vector<LegendEntry> entries;
  for (std::size_t i = 0; i < std::min(labels.size(), kMostEntries); ++i) {
    const std::string style = "sample " + LabelLineStyle(static_cast<int>(i));
    entries.push_back({fmt::format("{}: {}", FittingText(labels[i].name, kNameWidth),
                                   CountText(labels[i].clip_count, "clip")),
                       [style](double x, double y) { return SvgLine(style, x, y, x + 20, y); }});
  }
  if (labels.size() > kMostEntries) {
    entries.push_back({fmt::format("and {} more", labels.size() - kMostEntries),
                       [](double, double) { return std::string(); }});
  }
  return entries;
}

}  // namespace

std::vector<int> LayersAbove(int bottom_layer) {
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
  for (const v1::RecognizeResponse& response : responses) layers.push_back(ProfileOf(response));
  if (layers.empty()) layers.emplace_back();
  const std::vector<PlotLabel> labels = PlotLabels(layers);
  const PanelAxes axes = AxesOf(layers, labels);
  const std::string title =
      fmt::format("Generation probability: {} in {}",
                  FittingText(request.observation().file().file_name(), kTitleNameWidth),
                  FittingText(ShortName(request.database()), kTitleNameWidth));
  const std::vector<std::string> lines = HeadingLines(request, layers.front(), labels.size());

  std::string body = HeadingSvg(kLeft, kWidth, title, lines);
  PictureFrame frame{kLeft, HeadingHeight(lines.size()) + kPanelTitleHeight, kWidth,
                     kPanelFrameHeight};
  double bottom = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    body += PanelSvg(layers[i], PanelTitle(layers[i], i == 0 && request.layer() == 0), axes, frame);
    bottom = frame.bottom() + kStripGap + kStripHeight;
    frame.top += kPanelHeight + kBetweenPanels;
  }
  body += XTicksSvg(bottom, TimeTicks(axes, frame)) +
          XCaptionSvg(frame, bottom, "middle of the window (s)");
  const Legend legend = LegendSvg(LegendOf(labels), kLeft, kLeft + kWidth + kRight,
                                  bottom + kBelowPanels, kBetweenLegendEntries);
  const double width = kLeft + kWidth + kRight;
  const double height = legend.last_y + kBelowLegend;
  return PictureHead(width, height, title, PanelStyleSheet(layers.front()) + LabelStyleSheet()) +
         BackgroundSvg(width, height) + body + legend.svg + "</svg>\n";
}

}  // namespace motiondb::client
