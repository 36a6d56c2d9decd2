#include "core/recognition/clip_generation.h"

#include <algorithm>
#include <limits>

#include "core/graph/generation.h"
#include "core/inference/lattice.h"
#include "core/model/model.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

WindowEmission::WindowEmission(const Model& model, int layer, const FrameMatrix& observation,
                               int frames)
    : model_(model), layer_(layer), observation_(observation) {
  log_density_.resize(frames, model.tree().node_count(layer));
}

void WindowEmission::MoveTo(int first, const Cancelled& cancelled) {
  ThrottledCancellation cancellation(cancelled);
  const auto frames = static_cast<int>(log_density_.rows());
  const int keep = std::clamp(computed_ - first, 0, frames);
  for (int t = 0; t < keep; ++t) log_density_.row(t) = log_density_.row(t + first - first_);
  for (int t = keep; t < frames; ++t) {
    if (cancellation.cancelled(log_density_.cols() * observation_.cols())) return;
    const float* x = observation_.row(first + t).data();
    for (Eigen::Index node = 0; node < log_density_.cols(); ++node) {
      const int branch = model_.tree().branch(layer_, static_cast<int>(node));
      log_density_(t, node) = model_.gaussians().LogDensity(branch, x);
    }
  }
  first_ = first;
  computed_ = first + frames;
}

double WindowEmission::LogEvidence() const {
  double sum = 0;
  for (Eigen::Index t = 0; t < log_density_.rows(); ++t) sum += LogSum(log_density_.row(t));
  return sum;
}

namespace {

// Returns the log probability that a clip's graph generates the window: eq. 7 with P_o in place of
// P_s.
double ClipLogGeneration(const ClipGraph& graph, const EmissionMatrix& log_density,
                         const RecognizeOptions& options, const Cancelled& cancelled) {
  const auto states = static_cast<Eigen::Index>(graph.nodes.size());
  EmissionMatrix emission(log_density.rows(), states);
  for (Eigen::Index s = 0; s < states; ++s) emission.col(s) = log_density.col(graph.nodes[s]);
  if (options.generation == Generation::kExact) {
    return LogGeneration(graph.transitions, emission, options.transition_floor, nullptr, cancelled);
  }
  Lattice lattice;
  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    LatticeFrame& frame = lattice.emplace_back();
    for (Eigen::Index s = 0; s < states; ++s) frame.nodes.push_back(static_cast<std::int32_t>(s));
    frame.log_emission = emission.row(t);
  }
  std::vector<double> logs{-std::numeric_limits<double>::infinity()};
  for (const NodePath& path : BestPaths(lattice, graph.transitions, options.transition_floor,
                                        options.path_count, cancelled)) {
    logs.push_back(path.log_probability);
  }
  return LogSum(logs);
}

}  // namespace

absl::StatusOr<std::vector<ClipScore>> ScoreGeneration(const Model& model, int layer,
                                                       const WindowEmission& emission,
                                                       const std::vector<int>& clips,
                                                       const RecognizeOptions& options,
                                                       const Cancelled& cancelled) {
  const double evidence = emission.LogEvidence();
  std::vector<ClipScore> scores;
  for (const int clip : clips) {
    const double log_generation = ClipLogGeneration(*model.clip_graph(layer, clip),
                                                    emission.log_density(), options, cancelled);
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    scores.push_back({clip, log_generation - evidence});
  }
  return scores;
}

void SortByGeneration(std::vector<ClipScore>& scores) {
  std::stable_sort(scores.begin(), scores.end(), [](const ClipScore& a, const ClipScore& b) {
    return a.log_probability > b.log_probability;
  });
}

}  // namespace motiondb::core
