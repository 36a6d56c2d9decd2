#include "core/recognition/clip_generation.h"

#include <algorithm>
#include <limits>

#include "core/graph/transition_graph.h"
#include "core/inference/lattice.h"
#include "core/model/clip_graphs.h"
#include "core/model/clip_mask.h"
#include "core/model/label_units.h"
#include "core/model/model.h"
#include "core/motion/execution.h"

namespace motiondb::core {

WindowEmission::WindowEmission(const Model& model, int layer, const FrameMatrix& observation,
                               int frames, const ClipMask* mask)
    : model_(model), layer_(layer), observation_(observation), mask_(mask) {
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
      log_density_(t, node) = IsAllowedNode(model_, layer_, static_cast<int>(node), mask_)
                                  ? model_.gaussians().LogDensity(branch, x)
                                  : -std::numeric_limits<double>::infinity();
    }
  }
  first_ = first;
  computed_ = first + frames;
}

double WindowEmission::Familiarity() const {
  return model_.familiarity().Rank(
      layer_, FamiliarityScore(AllowedGraph(model_, layer_, mask_), log_density_));
}

double WindowEmission::LogEvidence() const {
  double sum = 0;
  for (Eigen::Index t = 0; t < log_density_.rows(); ++t) sum += LogSum(log_density_.row(t));
  return sum;
}

namespace {

// Returns the log probability that a clip's or unit's graph generates the window: eq. 7 with P_o in
// place of P_s.
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

absl::StatusOr<std::vector<UnitEvidence>> ScoreGeneration(const Model& model, int layer,
                                                          const WindowEmission& emission,
                                                          const LabelUnits& units,
                                                          const RecognizeOptions& options,
                                                          const Cancelled& cancelled) {
  const double evidence = emission.LogEvidence();
  std::vector<UnitEvidence> scores;
  for (const LabelUnit& unit : units.all()) {
    const double log_generation = ClipLogGeneration(*UnitGraph(model, layer, unit),
                                                    emission.log_density(), options, cancelled);
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    scores.push_back({&unit, log_generation - evidence});
  }
  return scores;
}

}  // namespace motiondb::core
