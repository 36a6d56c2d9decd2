#include "core/model/clip_graphs.h"

namespace motiondb::core {
namespace {

std::vector<std::int32_t> NodesOf(const Tree& tree, int layer, const ModelClip& clip) {
  std::vector<std::int32_t> nodes;
  nodes.reserve(clip.frame_count);
  for (int f = 0; f < clip.frame_count; ++f) {
    nodes.push_back(tree.node_of_frame(layer, clip.first_frame + f));
  }
  return nodes;
}

}  // namespace

ClipGraphs CountClipGraphs(const Tree& tree, const ModelClip& clip) {
  ClipGraphs graphs;
  graphs.reserve(tree.layer_count());
  for (int layer = 1; layer <= tree.layer_count(); ++layer) {
    graphs.push_back(CountClipTransitions(NodesOf(tree, layer, clip)));
  }
  return graphs;
}

TransitionGraph CountGlobalGraph(const Tree& tree, int layer, std::span<const ModelClip> clips) {
  std::vector<std::vector<std::int32_t>> sequences;
  for (const ModelClip& clip : clips) sequences.push_back(NodesOf(tree, layer, clip));
  return CountTransitions(sequences, tree.node_count(layer));
}

}  // namespace motiondb::core
