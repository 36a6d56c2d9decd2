// The stored motion that a plan may play.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/graph/transition_graph.h"

namespace motiondb::core {

class ClipMask;
class Model;

// Frames of the clips that `mask` allows (null: all), of those that have one of `labels` on `track`
// (no label: all).
struct Playable {
  std::vector<std::string> labels = {};
  std::string track = {};  // empty: kActionTrack
  std::shared_ptr<const ClipMask> mask = nullptr;
};

// Consecutive playable frames [first, end) of one clip.
struct PlayableRange {
  int clip = 0;
  int first = 0;
  int end = 0;
};

// Returns all ranges, in the order of the frames. Successive spans with labels are one range.
// O(clips).
std::vector<PlayableRange> PlayableRanges(const Model& model, const Playable& playable);

// Returns the transitions between nodes of a layer within the ranges.
TransitionGraph PlayableGraph(const Model& model, int layer, const Playable& playable);

}  // namespace motiondb::core
