#include "core/model/clip_index.h"

#include "core/model/clip_graphs.h"
#include "core/model/metric_frames.h"
#include "core/model/model.h"

namespace motiondb::core {
namespace {

// Every indexed node is compared with every observed frame, so their number is limited.
constexpr int kMaxNodes = 2048;

int IndexedLayer(const Tree& tree) {
  int layer = tree.layer_count();
  while (layer > 1 && tree.node_count(layer) > kMaxNodes) --layer;
  return layer;
}

}  // namespace

ClipIndex ClipIndex::Of(const ModelParts& parts) {
  ClipIndex index;
  if (parts.metric.empty()) return index;
  const int layer = IndexedLayer(parts.tree);
  const int nodes = parts.tree.node_count(layer);
  for (int node = 0; node < nodes; ++node) {
    index.branches_.push_back(parts.tree.branch(layer, node));
  }
  index.means_ = index.MeansIn(parts.metric, parts.gaussians);
  index.squared_norms_ = index.means_.rowwise().squaredNorm();

  std::vector<std::vector<int>> of_node(nodes);
  for (std::size_t clip = 0; clip < parts.clip_graphs.size(); ++clip) {
    for (const int node : NodesAbove(parts.tree, layer, parts.clip_graphs[clip]->nodes)) {
      std::vector<int>& clips = of_node[node];
      if (clips.empty() || clips.back() != static_cast<int>(clip)) {
        clips.push_back(static_cast<int>(clip));
      }
    }
  }
  for (const std::vector<int>& clips : of_node) {
    index.begin_.push_back(static_cast<int>(index.clips_.size()));
    index.clips_.insert(index.clips_.end(), clips.begin(), clips.end());
  }
  index.begin_.push_back(static_cast<int>(index.clips_.size()));
  return index;
}

ClipIndex ClipIndex::Restricted(const std::vector<bool>& allowed) const {
  ClipIndex restricted;
  std::vector<int> nodes;
  restricted.begin_.push_back(0);
  for (int node = 0; node < node_count(); ++node) {
    for (const int clip : clips(node)) {
      if (allowed[static_cast<std::size_t>(clip)]) restricted.clips_.push_back(clip);
    }
    const auto end = static_cast<int>(restricted.clips_.size());
    if (end == restricted.begin_.back()) continue;
    nodes.push_back(node);
    restricted.begin_.push_back(end);
    restricted.branches_.push_back(branches_[node]);
  }
  restricted.means_ = means_(nodes, Eigen::all);
  restricted.squared_norms_ = squared_norms_(nodes);
  return restricted;
}

FrameMatrix ClipIndex::MeansIn(const MotionMetric& metric, const NodeGaussians& gaussians) const {
  return Project(metric, gaussians.means()(branches_, Eigen::all));
}

}  // namespace motiondb::core
