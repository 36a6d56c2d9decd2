#include "core/inference/predict.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "core/inference/stored_futures.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr int kExemplars = 32;
constexpr int kMinPool = 512;       // stored frames to choose exemplars from, if there are as many
constexpr double kPoolMass = 0.99;  // of the state's distribution
constexpr double kLikelyNext = 1e-3;  // next nodes less probable than this are left out
constexpr double kAgreement =
    0.1;  // leg lengths: futures this near to the prediction agree with it

absl::Status CheckOptions(const PredictOptions& options) {
  if (!(options.history_seconds > 0 && std::isfinite(options.history_seconds))) {
    return InvalidArgument("history_seconds: expected more than 0, got {}",
                           options.history_seconds);
  }
  if (!(options.transition_floor >= 0 && options.transition_floor <= 1)) {
    return InvalidArgument("transition_floor: expected 0 to 1, got {}", options.transition_floor);
  }
  for (std::size_t h = 0; h < options.horizon_seconds.size(); ++h) {
    const double seconds = options.horizon_seconds[h];
    if (!(seconds >= 0 && seconds <= 3600)) {
      return InvalidArgument("horizon_seconds[{}]: expected 0 to 3600, got {}", h, seconds);
    }
  }
  return absl::OkStatus();
}

// The observation up to `frame`, `history` frames of it. Velocities of the last frame must not know
// the next one: they become backward differences.
StateSequence Past(const StateSequence& observation, int frame, int history) {
  const int count = std::min(history, frame + 1);
  const int first = frame + 1 - count;
  StateSequence past{observation.frame_rate_hz, observation.leg_length_m,
                     observation.states.middleRows(first, count),
                     observation.root_path.middleRows(first, count)};
  if (frame == 0 || frame + 1 == observation.frame_count()) return past;

  StateSequence last_two{observation.frame_rate_hz, observation.leg_length_m,
                         observation.states.middleRows(frame - 1, 2),
                         observation.root_path.middleRows(frame - 1, 2)};
  const FrameMatrix positions = WorldPositions(last_two);
  const double c = std::cos(observation.root_path(frame, 2));
  const double s = std::sin(observation.root_path(frame, 2));
  const auto to_states = static_cast<float>(observation.frame_rate_hz / observation.leg_length_m);
  for (Eigen::Index m = 0; m < positions.cols() / 3; ++m) {
    const Eigen::RowVector3f v =
        (positions.row(1) - positions.row(0)).segment<3>(3 * m) * to_states;
    past.states.row(count - 1).segment<3>(6 * m + 3) << static_cast<float>(c * v.x() + s * v.y()),
        static_cast<float>(-s * v.x() + c * v.y()), v.z();
  }
  return past;
}

// The next different node: where the graph goes from each node the motion may be in now, staying
// left out, weighted by how probable that node is.
std::vector<NextNode> NextNodes(const Model& model, int layer, const std::vector<NodeState>& now) {
  const TransitionGraph& graph = model.global_graph(layer);
  std::map<int, double> probability;
  double total = 0;
  for (const NodeState& state : now) {
    const double leaving =
        static_cast<double>(graph.row_sum(state.node)) - graph.count(state.node, state.node);
    if (leaving <= 0) continue;
    total += state.probability;
    for (const Edge& edge : graph.row(state.node)) {
      if (edge.to != state.node) {
        probability[edge.to] += state.probability * edge.count / leaving;
      }
    }
  }
  std::vector<NextNode> next;
  for (const auto& [node, p] : probability) {
    if (p / total >= kLikelyNext) next.push_back({node, p / total, {}});
  }
  std::stable_sort(next.begin(), next.end(), [](const NextNode& a, const NextNode& b) {
    return a.probability > b.probability;
  });
  const auto& clips = model.clip_graphs(layer);
  for (int c = 0; c < static_cast<int>(clips.size()); ++c) {
    const auto state_of = [&](int node) {
      const auto& nodes = clips[c].nodes;
      const auto at = std::lower_bound(nodes.begin(), nodes.end(), node);
      return at != nodes.end() && *at == node ? static_cast<int>(at - nodes.begin()) : -1;
    };
    for (NextNode& candidate : next) {
      const int to = state_of(candidate.node);
      if (to < 0) continue;
      const bool makes = std::any_of(now.begin(), now.end(), [&](const NodeState& state) {
        const int from = state.node == candidate.node ? -1 : state_of(state.node);
        return from >= 0 && clips[c].transitions.count(from, to) > 0;
      });
      if (makes) candidate.clips.push_back(c);
    }
  }
  return next;
}

// Branches whose frames serve as exemplars: those the motion is most probably in, and then their
// ancestors until there are enough frames to choose from.
std::vector<int> ExemplarPool(const Model& model, int layer, const std::vector<NodeState>& now) {
  std::vector<int> pool;
  double mass = 0;
  for (const NodeState& state : now) {
    if (mass >= kPoolMass) break;
    pool.push_back(model.tree().branch(layer, state.node));
    mass += state.probability;
  }
  const auto& branches = model.tree().branches();
  while (true) {
    std::sort(pool.begin(), pool.end());
    pool.erase(std::unique(pool.begin(), pool.end()), pool.end());
    // A branch under another one of the pool is already in it.
    std::erase_if(pool, [&](int b) {
      for (int up = branches[b].parent; up >= 0; up = branches[up].parent) {
        if (std::binary_search(pool.begin(), pool.end(), up)) return true;
      }
      return false;
    });
    int frames = 0;
    for (int b : pool) frames += branches[b].end - branches[b].begin;
    if (frames >= kMinPool || pool == std::vector<int>{0}) return pool;
    for (int& b : pool) b = std::max(branches[b].parent, 0);
  }
}

PredictedFrame PredictFrame(const Model& model, const StateSequence& past,
                            const std::vector<Exemplar>& exemplars, double seconds) {
  const Eigen::Index numbers = past.states.cols() / 2;
  std::vector<std::pair<double, Eigen::VectorXd>> futures;
  double weight = 0;
  Eigen::VectorXd displacement = Eigen::VectorXd::Zero(numbers);
  for (const Exemplar& exemplar : exemplars) {
    Eigen::VectorXd future =
        FutureDisplacement(model, exemplar.frame, seconds * past.frame_rate_hz);
    if (future.size() == 0) continue;
    displacement += exemplar.weight * future;
    weight += exemplar.weight;
    futures.emplace_back(exemplar.weight, std::move(future));
  }
  if (weight > 0) displacement /= weight;

  // The pose now, with missing markers as the exemplars have them, moved by the displacement.
  StateSequence pose{past.frame_rate_hz, past.leg_length_m, past.states.bottomRows(1),
                     past.root_path.bottomRows(1)};
  for (Eigen::Index m = 0; m < numbers / 3; ++m) {
    auto position = pose.states.row(0).segment<3>(6 * m);
    if (position.hasNaN()) {
      position.setZero();
      for (const Exemplar& exemplar : exemplars) {
        position += static_cast<float>(exemplar.weight) *
                    model.states()
                        .row(exemplar.frame)
                        .segment<3>(6 * m)
                        .cwiseProduct(model.scale().divisor.segment<3>(6 * m));
      }
    }
    position += displacement.segment<3>(3 * m).cast<float>().transpose();
  }
  PredictedFrame predicted;
  predicted.seconds = seconds;
  predicted.marker_positions_m = WorldPositions(pose).row(0);
  // How much of the weight lies with futures that end near the prediction.
  for (const auto& [share, future] : futures) {
    const double apart =
        std::sqrt((future - displacement).squaredNorm() / (static_cast<double>(numbers) / 3));
    if (apart <= kAgreement) predicted.confidence += share;
  }
  predicted.confidence = std::min(predicted.confidence, 1.0);
  return predicted;
}

}  // namespace

absl::StatusOr<Prediction> Predict(const Model& model, const StateSequence& observation,
                                   const PredictOptions& options, const Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  if (observation.frame_count() == 0) return InvalidArgument("observation: it has no frames");
  const double rate = observation.frame_rate_hz;
  const double end = (observation.frame_count() - 1) / rate;
  const double at = options.at_seconds.value_or(end);
  if (!(at >= 0 && at <= end + 1 / rate)) {
    return InvalidArgument("at_seconds: expected 0 to {:.3f}, the observation's length, got {}",
                           end, at);
  }
  const int frame =
      std::min(static_cast<int>(std::lround(at * rate)), observation.frame_count() - 1);
  const int history =
      static_cast<int>(std::clamp(std::round(options.history_seconds * rate), 1.0, frame + 1.0));
  const StateSequence past = Past(observation, frame, history);
  MOTIONDB_ASSIGN_OR_RETURN(const FrameMatrix scaled, ScaledObservation(model, past));

  NodePathOptions search_options;
  search_options.layer = options.layer;
  search_options.transition_floor = options.transition_floor;
  MOTIONDB_ASSIGN_OR_RETURN(const PathSearch search,
                            FindNodePaths(model, scaled, search_options, cancelled));
  const Eigen::VectorXd last = LastNodeDistribution(
      search.lattice, model.global_graph(search.layer), options.transition_floor);
  std::vector<NodeState> now;  // most probable first
  for (Eigen::Index i = 0; i < last.size(); ++i) {
    if (last[i] > 0) now.push_back({search.lattice.back().nodes[i], last[i]});
  }
  std::stable_sort(now.begin(), now.end(), [](const NodeState& a, const NodeState& b) {
    return a.probability > b.probability;
  });

  Prediction prediction;
  prediction.at_seconds = frame / rate;
  prediction.layer = search.layer;
  prediction.state = now.front();
  prediction.next_nodes = NextNodes(model, search.layer, now);
  const auto exemplars = NearestFrames(model, ExemplarPool(model, search.layer, now),
                                       scaled.row(scaled.rows() - 1).data(), kExemplars);
  for (double seconds : options.horizon_seconds) {
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    prediction.horizons.push_back(PredictFrame(model, past, exemplars, seconds));
  }
  return prediction;
}

}  // namespace motiondb::core
