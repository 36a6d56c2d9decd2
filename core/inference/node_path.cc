#include "core/inference/node_path.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/execution.h"

namespace motiondb::core {
namespace {

constexpr Eigen::Index kMaxCells = 1 << 25;  // frames x nodes, some 24 bytes each
constexpr Eigen::Index kMaxSteps = 1 << 26;  // frames x nodes x paths, 16 bytes each

// Maximum number of candidates of a frame; with a beam, the children of those kept.
Eigen::Index MaxCandidates(const NodePathOptions& options, Eigen::Index nodes) {
  if (options.max_candidates == 0) return nodes;
  return std::min<Eigen::Index>(2 * static_cast<Eigen::Index>(options.max_candidates), nodes);
}

absl::Status QueryCancelled() { return absl::CancelledError("the query was cancelled"); }

// Candidates of one frame during the descent: nodes of the current layer with their log densities.
struct Descent {
  std::vector<std::int32_t> nodes;
  std::vector<double> log_density;
};

// Returns the allowed children of a frame's candidates. A copy of a leaf keeps its density.
Descent Children(const Model& model, int layer, const ClipMask* mask, const Descent& above,
                 const float* state) {
  const Tree& tree = model.tree();
  Descent below;
  below.nodes.reserve(2 * above.nodes.size());
  below.log_density.reserve(2 * above.nodes.size());
  for (std::size_t i = 0; i < above.nodes.size(); ++i) {
    const int first = tree.first_child(layer, above.nodes[i]);
    const int count = tree.child_count(layer, above.nodes[i]);
    for (int c = first; c < first + count; ++c) {
      if (!IsAllowedNode(model, layer + 1, c, mask)) continue;
      below.nodes.push_back(c);
      below.log_density.push_back(
          count == 1 ? above.log_density[i]
                     : model.gaussians().LogDensity(tree.branch(layer + 1, c), state));
    }
  }
  return below;
}

Lattice MakeLattice(const std::vector<Descent>& frames) {
  Lattice lattice;
  lattice.reserve(frames.size());
  for (const Descent& frame : frames) {
    LatticeFrame& made = lattice.emplace_back();
    made.nodes = frame.nodes;
    made.log_emission = Eigen::Map<const Eigen::VectorXd>(
        frame.log_density.data(), static_cast<Eigen::Index>(frame.log_density.size()));
    NormalizeEmission(made.log_emission);
  }
  return lattice;
}

// Keeps the candidates on the best paths. If the strict rule leaves no path, keeps the most likely.
void Prune(const Lattice& lattice, const TransitionGraph& graph, const NodePathOptions& options,
           const Cancelled& cancelled, std::vector<Descent>& frames) {
  const auto limit = static_cast<std::size_t>(options.max_candidates);
  if (std::all_of(frames.begin(), frames.end(),
                  [&](const Descent& frame) { return frame.nodes.size() <= limit; })) {
    return;
  }
  const auto marginals = MaxMarginals(lattice, graph, options.transition_floor, cancelled);
  if (cancelled && cancelled()) return;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    Descent& frame = frames[t];
    if (frame.nodes.size() <= limit) continue;
    const bool any = std::isfinite(marginals[t].maxCoeff());
    const Eigen::VectorXd& score = any ? marginals[t] : lattice[t].log_emission;
    std::vector<int> order(frame.nodes.size());
    std::iota(order.begin(), order.end(), 0);
    std::nth_element(
        order.begin(), order.begin() + options.max_candidates, order.end(),
        [&](int a, int b) { return std::pair(-score[a], a) < std::pair(-score[b], b); });
    order.resize(limit);
    std::sort(order.begin(), order.end());
    Descent kept;
    kept.nodes.reserve(limit);
    kept.log_density.reserve(limit);
    for (int i : order) {
      kept.nodes.push_back(frame.nodes[i]);
      kept.log_density.push_back(frame.log_density[i]);
    }
    frame = std::move(kept);
  }
}

}  // namespace

absl::Status CheckPathCount(int path_count) {
  if (path_count >= 1 && path_count <= 100) return absl::OkStatus();
  return FieldViolation("path_count", "expected 1 to 100, got {}", path_count);
}

absl::Status CheckTransitionFloor(double transition_floor) {
  if (transition_floor >= 0 && transition_floor <= 1) return absl::OkStatus();
  return FieldViolation("transition_floor", "expected 0 to 1, got {}", transition_floor);
}

absl::Status CheckOptions(const NodePathOptions& options) {
  MOTIONDB_RETURN_IF_ERROR(CheckPathCount(options.path_count));
  MOTIONDB_RETURN_IF_ERROR(CheckTransitionFloor(options.transition_floor));
  if (options.max_candidates < 0) {
    return FieldViolation("max_candidates", "expected 0 or more, got {}", options.max_candidates);
  }
  return absl::OkStatus();
}

absl::StatusOr<Lattice> DescendTree(const Model& model, const FrameMatrix& observation,
                                    const NodePathOptions& options, const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const int bottom, model.ResolveLayer(options.layer));
  const Eigen::Index candidates = MaxCandidates(options, model.tree().node_count(bottom));
  if (observation.rows() * candidates > kMaxCells) {
    return FieldViolation("max_candidates",
                          "{} of {} nodes of layer {} for {} frames need too much memory; use "
                          "fewer candidates or a shorter observation",
                          candidates, model.tree().node_count(bottom), bottom, observation.rows());
  }
  const ClipMask* const mask = options.mask.get();
  ThrottledCancellation cancellation(cancelled);
  std::vector<Descent> frames;
  for (Eigen::Index t = 0; t < observation.rows(); ++t) {
    frames.push_back({{0}, {model.gaussians().LogDensity(0, observation.row(t).data())}});
  }
  for (int layer = 1; layer < bottom; ++layer) {
    if (cancelled && cancelled()) return QueryCancelled();
    for (Eigen::Index t = 0; t < observation.rows(); ++t) {
      const auto densities = 2 * std::ssize(frames[t].nodes);
      if (cancellation.cancelled(densities * observation.cols())) return QueryCancelled();
      frames[t] = Children(model, layer, mask, frames[t], observation.row(t).data());
    }
    if (options.max_candidates > 0 && layer + 1 < bottom) {
      Prune(MakeLattice(frames), AllowedGraph(model, layer + 1, mask), options, cancelled, frames);
    }
  }
  if (cancelled && cancelled()) return QueryCancelled();
  return MakeLattice(frames);
}

absl::StatusOr<PathSearch> FindNodePaths(const Model& model, const FrameMatrix& observation,
                                         const NodePathOptions& options,
                                         const Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  PathSearch search{.mask = options.mask};
  MOTIONDB_ASSIGN_OR_RETURN(search.layer, model.ResolveLayer(options.layer));
  const Eigen::Index candidates = MaxCandidates(options, model.tree().node_count(search.layer));
  if (observation.rows() * candidates * options.path_count > kMaxSteps) {
    return FieldViolation("path_count",
                          "{} paths to each of {} nodes for {} frames need too much memory; use "
                          "fewer paths or a shorter observation",
                          options.path_count, candidates, observation.rows());
  }
  MOTIONDB_ASSIGN_OR_RETURN(search.lattice, DescendTree(model, observation, options, cancelled));
  search.paths = BestPaths(search.lattice, AllowedGraph(model, search.layer, search.mask.get()),
                           options.transition_floor, options.path_count, cancelled);
  if (cancelled && cancelled()) return QueryCancelled();
  if (!search.paths.empty()) return search;
  if (options.max_candidates == 0) {
    return FailedPrecondition(
        "no stored transitions explain the observation in layer {}; set a transition floor above 0",
        search.layer);
  }
  // Pruning may remove every path that the strict rule allows, so repeat with exact search.
  NodePathOptions exact = options;
  exact.max_candidates = 0;
  return FindNodePaths(model, observation, exact, cancelled);
}

absl::StatusOr<std::vector<NodeState>> LastNodes(const Model& model, const PathSearch& search,
                                                 double transition_floor,
                                                 const Cancelled& cancelled) {
  const Eigen::VectorXd last =
      LastNodeDistribution(search.lattice, AllowedGraph(model, search.layer, search.mask.get()),
                           transition_floor, cancelled);
  if (cancelled && cancelled()) return QueryCancelled();
  std::vector<NodeState> nodes;
  for (Eigen::Index i = 0; i < last.size(); ++i) {
    if (last[i] > 0) nodes.push_back({search.lattice.back().nodes[i], last[i]});
  }
  std::stable_sort(nodes.begin(), nodes.end(), [](const NodeState& a, const NodeState& b) {
    return a.probability > b.probability;
  });
  return nodes;
}

}  // namespace motiondb::core
