// Transition graphs of clips and of all clips. A clip's graph is stored for the bottom layer only;
// graphs of other layers are computed from it by merging nodes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/model/model.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// Returns the clip's graph on the bottom layer.
ClipGraph CountClipGraph(const Tree& tree, const ModelClip& clip);

// Returns, for each node of the bottom layer, the node of `layer` that contains it. Ascending input
// gives ascending output.
std::vector<std::int32_t> NodesAbove(const Tree& tree, int layer,
                                     std::span<const std::int32_t> bottom_nodes);

// Returns a clip's graph on a layer, computed from its graph on the bottom layer.
// O(states + transitions log transitions).
ClipGraph ClipGraphAbove(const Tree& tree, int layer, const ClipGraph& bottom);

// Returns the graph of one layer over all clips.
TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips);

}  // namespace motiondb::core
