#include "client/cli/plot/recognition_plot_profile.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "client/cli/database_text.h"
#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_panel.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

// Counts the windows where each clip is the best, or among the best three.
void CountBest(LayerProfile& layer) {
  constexpr std::size_t kNear = 3;
  std::vector<ClipProfile*> clips;
  for (std::size_t i = 0; i < layer.windows.size(); ++i) {
    clips.clear();
    for (ClipProfile& clip : layer.clips) {
      if (std::isfinite(clip.log_probability[i])) clips.push_back(&clip);
    }
    const std::size_t near = std::min(kNear, clips.size());
    // Comparing pointers is deterministic: they point into one vector.
    std::partial_sort(clips.begin(), clips.begin() + static_cast<std::ptrdiff_t>(near), clips.end(),
                      [i](const ClipProfile* a, const ClipProfile* b) {
                        return std::pair(-a->log_probability[i], a) <
                               std::pair(-b->log_probability[i], b);
                      });
    if (near > 0) ++clips[0]->windows_best;
    for (std::size_t rank = 0; rank < near; ++rank) ++clips[rank]->windows_near;
  }
}

void ChooseLines(std::vector<ClipProfile>& clips) {
  constexpr std::size_t kMaxClips = 24, kMaxLines = 12, kMaxBestLines = 20;
  if (clips.size() <= kMaxClips) return;
  std::vector<ClipProfile*> ranked;
  ranked.reserve(clips.size());
  for (ClipProfile& clip : clips) ranked.push_back(&clip);
  std::stable_sort(ranked.begin(), ranked.end(), [](const ClipProfile* a, const ClipProfile* b) {
    return std::pair(a->windows_best, a->windows_near) >
           std::pair(b->windows_best, b->windows_near);
  });
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    ranked[i]->is_line = (ranked[i]->windows_best > 0 && i < kMaxBestLines) ||
                         (ranked[i]->windows_near > 0 && i < kMaxLines);
  }
}

}  // namespace

LayerProfile LayerProfileFrom(const v1::RecognizeResponse& response) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  PlotWindows drawn = PlotWindowsOf(response);
  const auto& windows = drawn.windows;
  LayerProfile profile;
  if (windows.empty()) return profile;
  profile.layer = windows.front()->layer();
  profile.window_seconds = windows.front()->end_seconds() - windows.front()->start_seconds();
  profile.windows = std::move(drawn.cells);
  std::map<std::string, ClipProfile> clips;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    bool explained = false;
    for (const v1::ClipProbability& clip : windows[i]->clips()) {
      ClipProfile& profile_of_clip = clips[clip.clip()];
      if (profile_of_clip.log_probability.empty()) {
        profile_of_clip.clip = ShortName(clip.clip());
        profile_of_clip.label = LabelOrPlaceholder(clip.label());
        profile_of_clip.log_probability.assign(windows.size(), kNone);
      }
      if (!std::isfinite(clip.log_probability())) continue;
      profile_of_clip.log_probability[i] = clip.log_probability();
      explained = true;
    }
    // If no clip has a path, all labels are equal, and none wins.
    profile.winners.emplace_back();
    if (explained && windows[i]->labels_size() > 0) {
      profile.winners.back() = LabelOrPlaceholder(windows[i]->labels(0).label());
    }
  }
  for (auto& [name, clip] : clips) profile.clips.push_back(std::move(clip));
  CountBest(profile);
  ChooseLines(profile.clips);
  return profile;
}

std::vector<PlotLabel> ProfileLabels(const std::vector<LayerProfile>& layers) {
  std::map<std::string, PlotLabel> found;
  for (const LayerProfile& layer : layers) {
    std::map<std::string, int> clip_counts;
    for (const ClipProfile& clip : layer.clips) {
      ++clip_counts[clip.label];
      if (clip.is_line) ++found[clip.label].line_count;
    }
    // All layers have the same clips, unless the model was replaced between the queries.
    for (const auto& [label, count] : clip_counts) {
      found[label].clip_count = std::max(found[label].clip_count, count);
    }
    for (const auto& winner : layer.winners) {
      if (winner) ++found[*winner].windows_won;
    }
  }
  return SortedLabels(found);
}

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

namespace {

PanelAxes AxesOf(const std::vector<LayerProfile>& layers, const std::vector<PlotLabel>& labels) {
  PanelAxes axes;
  axes.label_indices = LabelIndices(labels);
  for (const LayerProfile& layer : layers) {
    for (const WindowCell& window : layer.windows) axes.time.Add(window);
    for (const ClipProfile& clip : layer.clips) {
      for (const double value : clip.log_probability) axes.log_probability.Add(value);
    }
  }
  return axes;
}

std::vector<std::string> ProfileHeading(const v1::RecognizeRequest& request,
                                        const LayerProfile& layer, std::size_t label_count) {
  std::string what =
      fmt::format("{}; {} of {}; only the tree and its graphs",
                  WindowsText(layer.windows, layer.window_seconds),
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

// Returns the number of clips in the grey bands of all panels: "188 other clips", "180-188 other
// clips", or nothing.
std::string BandText(const std::vector<LayerProfile>& layers) {
  std::size_t least = std::numeric_limits<std::size_t>::max(), most = 0;
  for (const LayerProfile& layer : layers) {
    const auto count = static_cast<std::size_t>(std::count_if(
        layer.clips.begin(), layer.clips.end(), [](const auto& clip) { return !clip.is_line; }));
    least = std::min(least, count);
    most = std::max(most, count);
  }
  if (most == 0) return "";
  return (least < most ? fmt::format("{}-", least) : "") + CountText(most, "other clip");
}

std::vector<LegendEntry> ProfileLegend(const std::vector<PlotLabel>& labels,
                                       const std::vector<LayerProfile>& layers) {
  constexpr double kNameWidth = 190;
  std::vector<LegendEntry> entries;
  std::size_t further = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i].line_count == 0 && labels[i].windows_won == 0) continue;  // part of the band
    if (entries.size() == kLabelStyles) {
      ++further;
      continue;
    }
    const std::string style = "sample " + LabelLineStyle(static_cast<int>(i));
    entries.push_back(
        {fmt::format("{}: {}", TruncateToWidth(labels[i].name, kNameWidth),
                     CountText(labels[i].clip_count, "clip")),
         [style](Canvas& canvas, double x, double y) { canvas.Line(style, x, y, x + 20, y); }});
  }
  if (further > 0) {
    entries.push_back({fmt::format("and {} more", further), [](Canvas&, double, double) {}});
  }
  if (const std::string others = BandText(layers); !others.empty()) {
    entries.push_back({"5 % to 95 % of " + others, [](Canvas& canvas, double x, double y) {
                         canvas.Rectangle("band", {x, y - 6, 20, 12});
                       }});
  }
  return entries;
}

}  // namespace

Canvas ProfilePicture(const v1::RecognizeRequest& request,
                      const std::vector<v1::RecognizeResponse>& responses) {
  constexpr double kBetweenPanels = 14;
  std::vector<LayerProfile> layers(responses.size());
  std::transform(responses.begin(), responses.end(), layers.begin(), LayerProfileFrom);
  if (layers.empty()) layers.emplace_back();
  const std::vector<PlotLabel> labels = ProfileLabels(layers);
  const PanelAxes axes = AxesOf(layers, labels);
  const std::string title = PlotTitle("Generation probability", request);
  const std::vector<std::string> lines = ProfileHeading(request, layers.front(), labels.size());

  Canvas canvas;
  AddPanelStyles(canvas, layers.front());
  DrawHeading(canvas, kPlotLeft, kPlotWidth, title, lines);
  PictureFrame frame{kPlotLeft, HeadingHeight(lines.size()) + kPanelTitleHeight, kPlotWidth,
                     kPanelFrameHeight};
  double bottom = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    DrawPanel(canvas, layers[i], PanelTitle(layers[i], i == 0 && request.layer() == 0), axes,
              frame);
    bottom = frame.bottom() + kStripGap + kStripHeight;
    frame.top += kPanelHeight + kBetweenPanels;
  }
  FinishPlot(canvas, title, axes.time, bottom, {ProfileLegend(labels, layers)});
  return canvas;
}

}  // namespace motiondb::client
