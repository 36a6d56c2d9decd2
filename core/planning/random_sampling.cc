#include "core/planning/random_sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/inference/node_path.h"
#include "core/kinematics/root_velocity.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/goal.h"
#include "core/planning/seeded.h"
#include "core/planning/synthesis.h"

namespace motiondb::core {
namespace {

constexpr double kMaxSteps = 4e6;                   // frames of all walks, at effort 1
constexpr std::int64_t kStepsBetweenChecks = 4096;  // between calls to the caller

// Returns the motion of each node of a layer in one frame, by its mean velocities.
std::vector<FloorPose> StepsOf(const Model& model, int layer, double leg_length_m) {
  const double rate = model.settings().frame_rate_hz;
  std::vector<FloorPose> steps;
  for (int node = 0; node < model.tree().node_count(layer); ++node) {
    const Eigen::RowVectorXf mean = model.gaussians()
                                        .means()
                                        .row(model.tree().branch(layer, node))
                                        .cwiseProduct(model.scale().divisor);
    const PlanarVelocity v = RootVelocityFromHips(model.marker_set(), mean);
    steps.push_back({leg_length_m * v.x / rate, leg_length_m * v.y / rate, v.yaw_rate / rate});
  }
  return steps;
}

int NextNode(const TransitionGraph& graph, int node, SeededSequence& random) {
  auto remaining =
      static_cast<std::int64_t>(random.Next() * static_cast<double>(graph.row_sum(node)));
  for (const Edge& edge : graph.row(node)) {
    remaining -= edge.count;
    if (remaining < 0) return edge.to;
  }
  return -1;
}

// Finds the bottom layer's nodes for the means of the coarse nodes.
absl::StatusOr<SampledPath> Descend(const Model& model, int layer,
                                    std::vector<std::int32_t> coarse_nodes,
                                    const FloorPose& coarse_end, double leg_length_m,
                                    std::shared_ptr<const ClipMask> mask,
                                    const Cancelled& cancelled) {
  FrameMatrix means(static_cast<Eigen::Index>(coarse_nodes.size()), model.states().cols());
  for (std::size_t t = 0; t < coarse_nodes.size(); ++t) {
    means.row(static_cast<Eigen::Index>(t)) =
        model.gaussians().means().row(model.tree().branch(layer, coarse_nodes[t]));
  }
  MOTIONDB_ASSIGN_OR_RETURN(PathSearch search,
                            FindNodePaths(model, means, {.mask = std::move(mask)}, cancelled));
  SampledPath path{.coarse_nodes = std::move(coarse_nodes),
                   .bottom_nodes = std::move(search.paths.front().nodes),
                   .root = {{}},
                   .coarse_end = coarse_end};
  const std::vector<FloorPose> steps = StepsOf(model, search.layer, leg_length_m);
  for (std::size_t t = 0; t + 1 < path.bottom_nodes.size(); ++t) {
    path.root.push_back(path.root.back() * steps[path.bottom_nodes[t]]);
  }
  return path;
}

struct Walk {
  std::vector<std::int32_t> nodes;
  FloorPose end;
  double violation = std::numeric_limits<double>::infinity();
};

}  // namespace

absl::StatusOr<SampledPaths> SampleWalks(const Model& model, int layer, int start_frame,
                                         const Playable& playable, double leg_length_m,
                                         const Obstacles& obstacles, const SearchSettings& settings,
                                         const PlanControl& control) {
  const std::vector<FloorPose> steps = StepsOf(model, layer, leg_length_m);
  const TransitionGraph graph = PlayableGraph(model, layer, playable);
  const int start = model.tree().node_of_frame(layer, start_frame);
  const auto max_length =
      static_cast<std::size_t>(settings.max_duration_seconds * settings.frame_rate_hz);
  const auto max_steps = static_cast<std::int64_t>(settings.effort * kMaxSteps);

  SampledPaths sampled;
  std::vector<Walk> reached;
  Walk nearest;
  SeededSequence random(settings.seed);
  std::int64_t step = 0;
  std::int64_t next_check = 0;
  while (step < max_steps && !sampled.time_up &&
         static_cast<int>(reached.size()) < settings.path_count) {
    ++sampled.effort.expansions;
    ++step;  // so that walks without steps end too
    Walk walk{.nodes = {start}, .end = {}};
    Walk best;  // the part of this walk that comes nearest
    std::size_t best_length = 0;
    if (step >= next_check) {
      next_check = step + kStepsBetweenChecks;
      if (control.cancelled && control.cancelled()) {
        return absl::CancelledError("the search was cancelled");
      }
      sampled.time_up = control.time_up && control.time_up();
    }
    while (walk.nodes.size() <= max_length) {
      ++step;
      walk.end = walk.end * steps[walk.nodes.back()];
      const int next = NextNode(graph, walk.nodes.back(), random);
      if (next < 0 || (!obstacles.empty() &&
                       Distance(obstacles, {walk.end.x, walk.end.y}) < obstacles.clearance_m)) {
        break;
      }
      walk.nodes.push_back(next);
      const GoalError error = ErrorAt(walk.end, settings.goal);
      walk.violation = std::max(0.0, error.position_m - settings.position_tolerance_m) +
                       std::max(0.0, error.heading_rad - settings.heading_tolerance_rad);
      if (walk.violation < best.violation)
        best = {.nodes = {}, .end = walk.end, .violation = walk.violation};
      if (walk.violation == best.violation) best_length = walk.nodes.size();
      if (walk.violation == 0) break;
    }
    if (best.violation == 0 || best.violation < nearest.violation) {
      walk.nodes.resize(best_length);
      best.nodes = std::move(walk.nodes);
      (best.violation == 0 ? reached.emplace_back() : nearest) = std::move(best);
    }
  }
  if (control.search_over) control.search_over();

  sampled.reached = !reached.empty();
  sampled.effort.improvements = static_cast<int>(reached.size());
  if (reached.empty() && !nearest.nodes.empty()) reached.push_back(std::move(nearest));
  for (Walk& walk : reached) {
    MOTIONDB_ASSIGN_OR_RETURN(SampledPath path,
                              Descend(model, layer, std::move(walk.nodes), walk.end, leg_length_m,
                                      playable.mask, control.cancelled));
    sampled.paths.push_back(std::move(path));
  }
  return sampled;
}

FrameMatrix MeanPositions(const Model& model, const std::vector<std::int32_t>& bottom_nodes,
                          const std::vector<FloorPose>& root, double leg_length_m) {
  FrameMatrix positions(static_cast<Eigen::Index>(bottom_nodes.size()), model.states().cols() / 2);
  for (std::size_t t = 0; t < bottom_nodes.size(); ++t) {
    const int branch = model.tree().branch(model.layer_count(), bottom_nodes[t]);
    const Eigen::RowVectorXf mean =
        model.gaussians().means().row(branch).cwiseProduct(model.scale().divisor);
    positions.row(static_cast<Eigen::Index>(t)) = OnFloor(PositionsOf(mean), leg_length_m, root[t]);
  }
  return positions;
}

}  // namespace motiondb::core
