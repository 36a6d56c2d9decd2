#include "core/model/familiarity.h"

#include <algorithm>

#include "core/model/even_spread.h"

namespace motiondb::core {
namespace {

constexpr int kMaxWindows = 512;
constexpr double kFloor = 1e-6;

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
  FamiliarityReference reference;
  reference.scores.assign(global_graphs.size(), std::vector<float>(windows.size()));
  parallel(static_cast<int>(windows.size()), [&](int w) {
    const FrameRun& window = windows[w];
    // A branch stands in several layers: its density is computed once. Its statistics are read once
    // for all frames, for those of all branches together are larger than any cache.
    EmissionMatrix by_branch(window.count, gaussians.branch_count());
    for (int b = 0; b < gaussians.branch_count(); ++b) {
      for (int t = 0; t < window.count; ++t) {
        by_branch(t, b) = gaussians.LogDensity(b, states.row(window.first + t).data());
      }
    }
    for (int layer = 1; layer <= tree.layer_count(); ++layer) {
      EmissionMatrix by_node(window.count, tree.node_count(layer));
      for (int t = 0; t < window.count; ++t) {
        for (int node = 0; node < tree.node_count(layer); ++node) {
          by_node(t, node) = by_branch(t, tree.branch(layer, node));
        }
      }
      reference.scores[layer - 1][w] =
          static_cast<float>(FamiliarityScore(global_graphs[layer - 1], by_node));
    }
  });
  for (std::vector<float>& scores : reference.scores) std::sort(scores.begin(), scores.end());
  return reference;
}

}  // namespace motiondb::core
