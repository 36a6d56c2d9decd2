// How clips pass through the nodes of a tree. Pure functions; safe to call from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/model/model.h"
#include "core/tree/tree.h"

namespace motiondb::core {

// The clip's graph on each layer.
ClipGraphs CountClipGraphs(const Tree& tree, const ModelClip& clip);

// The graph of one layer over all these clips.
TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips);

}  // namespace motiondb::core
