#include "core/model/familiarity.h"

#include <algorithm>
#include <limits>
#include <span>

#include "core/motion/samples.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

constexpr int kMaxWindows = 256;
constexpr double kFloor = 1e-6;
constexpr int kWindowsAtOnce = 32;    // windows that share one pass over the node statistics
constexpr float kMaxLogDeficit = 40;  // e^-40 / kFloor is less than a float's rounding
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

// The nodes of each branch: one in each of its layers, in order of the layers.
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

// Likely nodes of one layer, for each frame.
using LikelyNodes = std::vector<std::vector<LikelyNode>>;

// Bounding box of frames, and for each layer the minimum log density of a node that
// is likely for at least one of these frames.
struct Box {
  Eigen::RowVectorXf lower;
  Eigen::RowVectorXf upper;
  Eigen::VectorXf min_density;       // [layer - 1]
  Eigen::VectorXf min_density_from;  // minimum over this layer and all deeper ones
};

// Frames of windows in the layout of LogDensitiesFrom: each window begins a new block. Also the
// minimum log density of a likely node (infinite for padding).
struct WindowFrames {
  FrameMatrix blocks;            // blocks of dimensions x kSquaresLanes, end to end
  FrameMatrix min_density;       // [layer - 1] x frames
  FrameMatrix min_density_from;  // minimum over this layer and all deeper ones
  std::vector<Box> of_block;
  std::vector<Box> of_window;
  std::vector<int> first_block;  // [window], and the number of blocks
};

int BlocksOf(const FrameRun& window) { return (window.count + kSquaresLanes - 1) / kSquaresLanes; }

Box BoxOf(const Eigen::Ref<const FrameMatrix>& states, const WindowFrames& frames, int place) {
  return {states.colwise().minCoeff(), states.colwise().maxCoeff(),
          frames.min_density.middleCols(place, states.rows()).rowwise().minCoeff(),
          frames.min_density_from.middleCols(place, states.rows()).rowwise().minCoeff()};
}

WindowFrames GatherFrames(std::span<const FrameRun> windows,
                          const Eigen::Ref<const FrameMatrix>& states, const Tree& tree,
                          const NodeGaussians& gaussians) {
  WindowFrames gathered;
  int blocks = 0;
  for (const FrameRun& window : windows) {
    gathered.first_block.push_back(blocks);
    blocks += BlocksOf(window);
  }
  gathered.first_block.push_back(blocks);
  gathered.blocks.setZero(blocks * states.cols(), kSquaresLanes);
  gathered.min_density.setConstant(tree.layer_count(), blocks * kSquaresLanes, kPadding);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    for (int t = 0; t < windows[w].count; ++t) {
      const int frame = windows[w].first + t;
      const int f = gathered.first_block[w] * kSquaresLanes + t;
      gathered.blocks.block(f / kSquaresLanes * states.cols(), f % kSquaresLanes, states.cols(),
                            1) = states.row(frame).transpose();
      int previous = -1;
      for (int layer = 1; layer <= tree.layer_count(); ++layer) {
        const int own = tree.branch(layer, tree.node_of_frame(layer, frame));
        gathered.min_density(layer - 1, f) =
            own == previous
                ? gathered.min_density(layer - 2, f)
                : static_cast<float>(gaussians.LogDensity(own, states.row(frame).data())) -
                      kMaxLogDeficit;
        previous = own;
      }
    }
  }
  gathered.min_density_from = gathered.min_density;
  for (Eigen::Index layer = tree.layer_count() - 2; layer >= 0; --layer) {
    gathered.min_density_from.row(layer) =
        gathered.min_density.row(layer).cwiseMin(gathered.min_density_from.row(layer + 1));
  }
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const int place = gathered.first_block[w] * kSquaresLanes;
    const auto rows = states.middleRows(windows[w].first, windows[w].count);
    gathered.of_window.push_back(BoxOf(rows, gathered, place));
    for (int t = 0; t < windows[w].count; t += kSquaresLanes) {
      const int lanes = std::min(kSquaresLanes, windows[w].count - t);
      gathered.of_block.push_back(BoxOf(rows.middleRows(t, lanes), gathered, place + t));
    }
  }
  return gathered;
}

// Returns the likely nodes of each layer. A branch spans several layers: its densities are computed
// once. Most branches are excluded by the bounding box of a window or block.
std::vector<LikelyNodes> FindLikelyNodes(const WindowFrames& frames, const Tree& tree,
                                         const NodesOfBranches& nodes,
                                         const NodeGaussians& gaussians) {
  const Eigen::Index block_size = gaussians.dimension_count() * kSquaresLanes;
  std::vector<LikelyNodes> likely(tree.layer_count(), LikelyNodes(frames.min_density.cols()));
  std::vector<float> scratch;
  float log_densities[kSquaresLanes];
  for (int b = 0; b < gaussians.branch_count(); ++b) {
    const int first_layer = tree.branches()[b].layer - 1;
    const bool has_one_layer = nodes[b].size() == 1;
    const FrameMatrix& threshold = has_one_layer ? frames.min_density : frames.min_density_from;
    const auto is_far = [&](const Box& box) {
      return gaussians.IsBoxBelow(
          b, box.lower.data(), box.upper.data(),
          (has_one_layer ? box.min_density : box.min_density_from)[first_layer]);
    };
    for (std::size_t w = 0; w < frames.of_window.size(); ++w) {
      if (is_far(frames.of_window[w])) continue;
      for (int block = frames.first_block[w]; block < frames.first_block[w + 1]; ++block) {
        const int first = block * kSquaresLanes;
        if (is_far(frames.of_block[block]) ||
            !gaussians.LogDensitiesFrom(b, frames.blocks.data() + block * block_size, 1,
                                        &threshold(first_layer, first), scratch, log_densities)) {
          continue;
        }
        for (int lane = 0; lane < kSquaresLanes; ++lane) {
          const int f = first + lane;
          if (!(log_densities[lane] >= threshold(first_layer, f))) continue;
          for (std::size_t i = 0; i < nodes[b].size(); ++i) {
            const std::size_t layer = first_layer + i;
            if (log_densities[lane] < frames.min_density(static_cast<Eigen::Index>(layer), f))
              continue;
            likely[layer][f].push_back({nodes[b][i], log_densities[lane]});
          }
        }
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
    const auto chunk_windows =
        std::span(windows).subspan(first, std::min(kWindowsAtOnce, count - first));
    const WindowFrames frames = GatherFrames(chunk_windows, states, tree, gaussians);
    const std::vector<LikelyNodes> likely = FindLikelyNodes(frames, tree, nodes, gaussians);
    std::vector<double> scratch;
    for (std::size_t layer = 0; layer < likely.size(); ++layer) {
      scratch.assign(global_graphs[layer].node_count(), 0);
      for (std::size_t w = 0; w < chunk_windows.size(); ++w) {
        const auto seen =
            std::span(likely[layer])
                .subspan(frames.first_block[w] * kSquaresLanes, chunk_windows[w].count);
        reference.scores[layer][first + w] = static_cast<float>(
            LogGenerationOfCandidates(global_graphs[layer], seen, kFloor, scratch) /
            chunk_windows[w].count);
      }
    }
  });
  for (std::vector<float>& scores : reference.scores) std::sort(scores.begin(), scores.end());
  return reference;
}

}  // namespace motiondb::core
