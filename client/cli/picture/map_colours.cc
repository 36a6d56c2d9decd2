#include "client/cli/picture/map_colours.h"

#include <fmt/format.h>

#include "client/cli/plot/recognition_plot_labels.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

MapColours::MapColours(const StateMap& map, MapColouring colouring)
    : kind_(colouring == MapColouring::kByClip ? "other clip" : "other label") {
  constexpr int kMaxNames = 8;
  const auto& names = colouring == MapColouring::kByClip ? map.clips() : map.labels();
  std::map<std::string, PlotLabel> groups;
  for (const std::string& name : names) groups.try_emplace(name);
  for (const MapNode& node : map.nodes()) {
    groups[names[static_cast<std::size_t>(node.main_clip)]].probability += node.frame_count;
  }
  std::map<std::string, int> places;
  for (const PlotLabel& group : SortedLabels(groups)) {
    if (static_cast<int>(names_.size()) < kMaxNames) {
      places.emplace(group.name, static_cast<int>(names_.size()));
      names_.push_back(group.name);
    } else {
      ++other_count_;
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto place = places.find(names[i]);
    if (place != places.end()) place_of_clip_[map.clips()[i]] = place->second;
  }
}

std::string MapColours::FillStyle(const std::string& clip) const {
  const auto place = place_of_clip_.find(clip);
  return place == place_of_clip_.end() ? "others" : LabelAreaStyle(place->second);
}

std::string MapColours::LineStyle(const std::string& clip) const {
  const auto place = place_of_clip_.find(clip);
  return place == place_of_clip_.end() ? "others-line" : LabelLineStyle(place->second);
}

void MapColours::AddStyles(Canvas& canvas) {
  AddLabelStyles(canvas);
  canvas.AddStyle("others", {.fill = "#c4c4c4"});
  canvas.AddStyle("others-line", {.stroke = "#c4c4c4"});
}

std::vector<LegendEntry> MapColours::Legend() const {
  constexpr double kNameWidth = 190;
  const auto entry = [](const std::string& name, const std::string& style) {
    return LegendEntry{
        name, [style](Canvas& canvas, double x, double y) { canvas.Circle(style, x + 10, y, 5); }};
  };
  std::vector<LegendEntry> entries;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    entries.push_back(
        entry(TruncateToWidth(names_[i], kNameWidth), LabelAreaStyle(static_cast<int>(i))));
  }
  if (other_count_ > 0) entries.push_back(entry(CountText(other_count_, kind_), "others"));
  return entries;
}

}  // namespace motiondb::client
