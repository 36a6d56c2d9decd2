// Transition graphs of clips and of all clips. A clip's graph is stored for the bottom layer only;
// graphs of other layers are computed from it by merging nodes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/graph/transition_graph.h"
#include "core/model/model.h"
#include "core/tree/tree.h"

namespace motiondb::core {

struct LabelUnit;

// Returns the clip's graph on the bottom layer.
ClipGraph CountClipGraph(const Tree& tree, const ModelClip& clip);
// Returns the graph of a unit on a layer. O(log frames of the unit) for each of its frames, or as
// ClipGraphAbove if it is a whole clip.
std::shared_ptr<const ClipGraph> UnitGraph(const Model& model, int layer, const LabelUnit& unit);

// Returns, for each node of the bottom layer, the node of `layer` that contains it. Ascending input
// gives ascending output.
std::vector<std::int32_t> NodesAbove(const Tree& tree, int layer,
                                     std::span<const std::int32_t> bottom_nodes);

// Returns a clip's graph on a layer, computed from its graph on the bottom layer.
// O(states + transitions log transitions).
ClipGraph ClipGraphAbove(const Tree& tree, int layer, const ClipGraph& bottom);

// Returns the graphs of all layers ([layer - 1]), each the sum over clips of their graphs on the
// bottom layer. O(edges of the clips and of the graphs, times their logarithm).
std::vector<TransitionGraph> SumClipGraphs(const Tree& tree,
                                           std::span<const ClipGraph* const> clips);

// Returns the graph of one layer over all clips.
TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips);

}  // namespace motiondb::core
