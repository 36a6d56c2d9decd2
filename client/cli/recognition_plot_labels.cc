#include "client/cli/recognition_plot_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

namespace motiondb::client {
namespace {

struct Colour {
  const char* code;
  const char* text;  // that is read on it
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
    // All layers have the same clips, unless the model changed in between.
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

std::map<std::string, int> PlacesOf(const std::vector<PlotLabel>& labels) {
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

}  // namespace motiondb::client
