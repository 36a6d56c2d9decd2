#include "core/planning/playable.h"

#include <algorithm>
#include <cstdint>

#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/model/model.h"

namespace motiondb::core {

std::vector<PlayableRange> PlayableRanges(const Model& model, const Playable& playable) {
  const auto units = UnitsOf(model, playable.track, playable.mask.get());
  std::vector<bool> is_playable(units->labels().size());
  for (std::size_t l = 0; l < is_playable.size(); ++l) {
    is_playable[l] =
        std::ranges::find(playable.labels, units->labels()[l]) != playable.labels.end();
  }
  std::vector<PlayableRange> ranges;
  for (const LabelUnit& unit : units->all()) {
    if (!playable.labels.empty() && (unit.label < 0 || !is_playable[unit.label])) continue;
    const int end = unit.first_frame + unit.frame_count;
    if (!ranges.empty() && ranges.back().clip == unit.clip &&
        ranges.back().end == unit.first_frame) {
      ranges.back().end = end;
    } else {
      ranges.push_back({unit.clip, unit.first_frame, end});
    }
  }
  return ranges;
}

TransitionGraph PlayableGraph(const Model& model, int layer, const Playable& playable) {
  if (playable.labels.empty()) return AllowedGraph(model, layer, playable.mask.get());
  std::vector<std::vector<std::int32_t>> sequences;
  for (const PlayableRange& range : PlayableRanges(model, playable)) {
    std::vector<std::int32_t>& nodes = sequences.emplace_back();
    for (int f = range.first; f < range.end; ++f) {
      nodes.push_back(model.tree().node_of_frame(layer, f));
    }
  }
  return CountTransitions(sequences, model.tree().node_count(layer));
}

}  // namespace motiondb::core
