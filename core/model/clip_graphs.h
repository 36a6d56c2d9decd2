// How clips pass through the nodes of a tree. A clip's graph is kept for the bottom layer alone; on
// a layer above, nodes and their transitions are those below put together. Pure functions; safe to
// call from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/model/model.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// The clip's graph on the bottom layer.
ClipGraph CountClipGraph(const Tree& tree, const ModelClip& clip);

// The nodes of a layer that hold these nodes of the bottom layer, each in its place. Ascending
// nodes give ascending ones.
std::vector<std::int32_t> NodesAbove(const Tree& tree, int layer,
                                     std::span<const std::int32_t> bottom_nodes);

// A clip's graph on a layer, from that on the bottom layer: what CountClipTransitions gives there.
// O(states + transitions log transitions).
ClipGraph ClipGraphAbove(const Tree& tree, int layer, const ClipGraph& bottom);

// The graph of one layer over all these clips.
TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips);

}  // namespace motiondb::core
