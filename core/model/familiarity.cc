#include "core/model/familiarity.h"

#include <algorithm>
#include <limits>
#include <span>

#include "core/model/even_spread.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

constexpr int kMaxWindows = 512;
constexpr double kFloor = 1e-6;
constexpr int kWindowsAtOnce = 8;  // statistics are read once for these
constexpr float kHopeless = 40;    // e^-40 / kFloor is less than a float's rounding
constexpr float kPadding = std::numeric_limits<float>::infinity();

std::vector<FrameRun> Windows(const std::vector<FrameRun>& clips, int window_frames) {
  std::vector<FrameRun> all;
  for (const FrameRun& clip : clips) {
    const int last_start = std::max(0, clip.count - window_frames);
    for (int start = 0; start <= last_start; ++start) {
      all.push_back({clip.first + start, std::min(window_frames, clip.count)});
    }
  }
  std::vector<FrameRun> spread;
  for (const int i : SpreadEvenly(std::ssize(all), kMaxWindows)) spread.push_back(all[i]);
  return spread;
}

// The nodes that stand for a branch: one in each layer from its first to its last.
class NodesOfBranches {
 public:
  explicit NodesOfBranches(const Tree& tree) : begin_(tree.branches().size() + 1) {
    const auto& branches = tree.branches();
    for (std::size_t b = 0; b < branches.size(); ++b) {
      const int layers = branches[b].left >= 0 ? 1 : tree.layer_count() + 1 - branches[b].layer;
      begin_[b + 1] = begin_[b] + layers;
    }
    nodes_.resize(begin_.back());
    for (int layer = 1; layer <= tree.layer_count(); ++layer) {
      for (int node = 0; node < tree.node_count(layer); ++node) {
        const int b = tree.branch(layer, node);
        nodes_[begin_[b] + layer - branches[b].layer] = node;
      }
    }
  }
  std::span<const std::int32_t> operator[](std::size_t branch) const {
    return std::span(nodes_).subspan(begin_[branch], begin_[branch + 1] - begin_[branch]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::int32_t> nodes_;
};

// Of one layer, for each of some frames.
using LikelyNodes = std::vector<std::vector<LikelyNode>>;

// Frames of windows, end to end, as LogDensitiesFrom takes them, and for each layer what a node's
// log density must be there (of padding: infinite).
struct WindowFrames {
  FrameMatrix blocks;         // blocks of dimensions x kSquaresLanes, end to end
  FrameMatrix at_least;       // [layer - 1] x frames
  FrameMatrix at_least_from;  // the least of this layer's and those below
};

WindowFrames GatherFrames(std::span<const FrameRun> windows,
                          const Eigen::Ref<const FrameMatrix>& states, const Tree& tree,
                          const NodeGaussians& gaussians) {
  int frames = 0;
  for (const FrameRun& window : windows) frames += window.count;
  const int blocks = (frames + kSquaresLanes - 1) / kSquaresLanes;
  WindowFrames gathered;
  gathered.blocks.setZero(blocks * states.cols(), kSquaresLanes);
  gathered.at_least.setConstant(tree.layer_count(), blocks * kSquaresLanes, kPadding);
  int f = 0;
  for (const FrameRun& window : windows) {
    for (int t = 0; t < window.count; ++t, ++f) {
      const int frame = window.first + t;
      gathered.blocks.block(f / kSquaresLanes * states.cols(), f % kSquaresLanes, states.cols(),
                            1) = states.row(frame).transpose();
      int known = -1;
      for (int layer = 1; layer <= tree.layer_count(); ++layer) {
        const int own = tree.branch(layer, tree.node_of_frame(layer, frame));
        gathered.at_least(layer - 1, f) =
            own == known ? gathered.at_least(layer - 2, f)
                         : static_cast<float>(gaussians.LogDensity(own, states.row(frame).data())) -
                               kHopeless;
        known = own;
      }
    }
  }
  gathered.at_least_from = gathered.at_least;
  for (Eigen::Index layer = tree.layer_count() - 2; layer >= 0; --layer) {
    gathered.at_least_from.row(layer) =
        gathered.at_least.row(layer).cwiseMin(gathered.at_least_from.row(layer + 1));
  }
  return gathered;
}

// For each layer. A branch stands in several layers: its densities are computed once.
std::vector<LikelyNodes> FindLikelyNodes(std::span<const FrameRun> windows,
                                         const Eigen::Ref<const FrameMatrix>& states,
                                         const Tree& tree, const NodesOfBranches& nodes,
                                         const NodeGaussians& gaussians) {
  const WindowFrames frames = GatherFrames(windows, states, tree, gaussians);
  const auto padded = static_cast<int>(frames.at_least.cols());
  std::vector<LikelyNodes> likely(tree.layer_count(), LikelyNodes(padded));
  std::vector<float> scratch;
  std::vector<float> log_densities(padded);
  for (int b = 0; b < gaussians.branch_count(); ++b) {
    const int first_layer = tree.branches()[b].layer - 1;
    const FrameMatrix& least = nodes[b].size() == 1 ? frames.at_least : frames.at_least_from;
    if (!gaussians.LogDensitiesFrom(b, frames.blocks.data(), padded / kSquaresLanes,
                                    least.row(first_layer).data(), scratch, log_densities.data())) {
      continue;
    }
    for (int f = 0; f < padded; ++f) {
      if (!(log_densities[f] >= least(first_layer, f))) continue;
      for (std::size_t i = 0; i < nodes[b].size(); ++i) {
        const std::size_t layer = first_layer + i;
        if (log_densities[f] < frames.at_least(static_cast<Eigen::Index>(layer), f)) continue;
        likely[layer][f].push_back({nodes[b][i], log_densities[f]});
      }
    }
  }
  return likely;
}

}  // namespace

double FamiliarityReference::Rank(int layer, double score) const {
  const std::vector<float>& sorted = scores[static_cast<std::size_t>(layer) - 1];
  if (sorted.empty()) return 0;
  const auto lower = std::lower_bound(sorted.begin(), sorted.end(), static_cast<float>(score));
  return static_cast<double>(lower - sorted.begin()) / static_cast<double>(sorted.size());
}

double FamiliarityScore(const TransitionGraph& graph,
                        const Eigen::Ref<const EmissionMatrix>& log_densities) {
  return LogGeneration(graph, log_densities, kFloor) / static_cast<double>(log_densities.rows());
}

FamiliarityReference MakeFamiliarityReference(const std::vector<FrameRun>& clips, int window_frames,
                                              const Eigen::Ref<const FrameMatrix>& states,
                                              const Tree& tree, const NodeGaussians& gaussians,
                                              const std::vector<TransitionGraph>& global_graphs,
                                              const ParallelFor& parallel) {
  const std::vector<FrameRun> windows = Windows(clips, window_frames);
  const NodesOfBranches nodes(tree);
  FamiliarityReference reference;
  reference.scores.assign(global_graphs.size(), std::vector<float>(windows.size()));
  const auto count = static_cast<int>(windows.size());
  parallel((count + kWindowsAtOnce - 1) / kWindowsAtOnce, [&](int chunk) {
    const int first = chunk * kWindowsAtOnce;
    const auto some = std::span(windows).subspan(first, std::min(kWindowsAtOnce, count - first));
    const std::vector<LikelyNodes> likely = FindLikelyNodes(some, states, tree, nodes, gaussians);
    std::vector<double> scratch;
    for (std::size_t layer = 0; layer < likely.size(); ++layer) {
      scratch.assign(global_graphs[layer].node_count(), 0);
      int frame = 0;
      for (std::size_t w = 0; w < some.size(); ++w) {
        const auto seen = std::span(likely[layer]).subspan(frame, some[w].count);
        reference.scores[layer][first + w] = static_cast<float>(
            LogGenerationAmong(global_graphs[layer], seen, kFloor, scratch) / some[w].count);
        frame += some[w].count;
      }
    }
  });
  for (std::vector<float>& scores : reference.scores) std::sort(scores.begin(), scores.end());
  return reference;
}

}  // namespace motiondb::core
