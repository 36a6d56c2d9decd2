#include "core/prediction/predict.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/estimation/estimate.h"
#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/motion_floor.h"
#include "core/motion/states.h"
#include "core/prediction/forecast.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {
namespace {

constexpr double kMinNextProbability = 1e-3;  // less probable next nodes are not reported
constexpr double kNear_m = 0.05;              // mean error to which the confidence refers

// Returns the distribution of the next different node: the graph's transitions to other nodes,
// weighted by the probabilities of the current nodes.
std::vector<NextNode> NextNodes(const Model& model, int layer, const std::vector<NodeState>& now,
                                const ClipMask* mask) {
  const TransitionGraph& graph = AllowedGraph(model, layer, mask);
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
    if (p / total >= kMinNextProbability) next.push_back({node, p / total, {}});
  }
  std::stable_sort(next.begin(), next.end(), [](const NextNode& a, const NextNode& b) {
    return a.probability > b.probability;
  });
  for (const int c : AllowedClips(model, mask)) {
    const auto clip = model.clip_graph(layer, c);
    const auto state_of = [&](int node) {
      const auto& nodes = clip->nodes;
      const auto at = std::lower_bound(nodes.begin(), nodes.end(), node);
      return at != nodes.end() && *at == node ? static_cast<int>(at - nodes.begin()) : -1;
    };
    for (NextNode& candidate : next) {
      const int to = state_of(candidate.node);
      if (to < 0) continue;
      const bool has_transition = std::any_of(now.begin(), now.end(), [&](const NodeState& state) {
        const int from = state.node == candidate.node ? -1 : state_of(state.node);
        return from >= 0 && clip->transitions.count(from, to) > 0;
      });
      if (has_transition) candidate.clips.push_back(c);
    }
  }
  return next;
}

// Returns `past` with its missing markers filled in.
absl::StatusOr<StateSequence> Complete(const Model& model, const PathSearch& search,
                                       const StateSequence& past, const FrameMatrix& scaled,
                                       const Cancelled& cancelled) {
  StateSequence complete = past;
  if (past.states.hasNaN()) {
    // Filled positions are floats, so they are computed near the origin.
    const Eigen::Vector2d origin = NearestCorner(past.root_path.row(0).head<2>().transpose());
    complete.root_path.leftCols<2>().rowwise() -= origin.transpose();
    const StateSequence near = complete;
    MOTIONDB_ASSIGN_OR_RETURN(
        const auto filled,
        FillMissing(model, near, scaled, search.layer, search.paths.front().nodes,
                    Fill::kEveryFrame, search.mask.get(), cancelled));
    ApplyFilled(filled, complete);
    complete.root_path = past.root_path;
  }
  return complete;
}

// Converts positions (3 N_v, leg lengths) from the last reference frame of `past` to its world.
PredictedFrame InWorld(const StateSequence& past, double seconds,
                       const Eigen::RowVectorXf& positions) {
  StateSequence pose{past.frame_rate_hz, past.leg_length_m,
                     FrameMatrix::Zero(1, 2 * positions.size()), past.root_path.bottomRows(1)};
  pose.floor_m = past.floor_m;
  for (Eigen::Index m = 0; m < positions.size() / 3; ++m) {
    pose.states.row(0).segment<3>(6 * m) = positions.segment<3>(3 * m);
  }
  return {.seconds = seconds, .marker_positions_m = WorldPositions(pose).row(0)};
}

// Predicts with the graph alone. Sets no confidence, because the error of this method is unknown.
absl::Status PredictByNodes(const Model& model, const StateSequence& past,
                            const std::vector<NodeState>& now, const PredictOptions& options,
                            const Cancelled& cancelled, Prediction& prediction) {
  const std::vector<double>& horizon_seconds = options.horizon_seconds;
  std::vector<std::size_t> order(horizon_seconds.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return horizon_seconds[a] < horizon_seconds[b];
  });
  prediction.horizons.resize(horizon_seconds.size());
  NodeForecaster forecaster(model, prediction.layer, now, options.mask.get());
  for (const std::size_t h : order) {
    const Eigen::RowVectorXf positions = forecaster.At(horizon_seconds[h], cancelled);
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    prediction.horizons[h] = InWorld(past, horizon_seconds[h], positions);
  }
  return absl::OkStatus();
}

// The observed moment and the motion before it.
struct Moment {
  int frame = 0;
  StateSequence past;
  FrameMatrix scaled;  // scaled states of `past`
};

absl::StatusOr<Moment> MomentOf(const Model& model, const StateSequence& observation,
                                const PredictOptions& options) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  if (observation.frame_count() == 0)
    return InvalidArgument("observation: expected at least one frame");
  const double rate = observation.frame_rate_hz;
  const double end = (observation.frame_count() - 1) / rate;
  const double at = options.at_seconds.value_or(end);
  if (!(at >= 0 && at <= end + 1 / rate)) {
    return FieldViolation("at_seconds",
                          "expected 0 to {:.3f} (last frame of the observation), got {}", end, at);
  }
  Moment moment;
  moment.frame = std::min(static_cast<int>(std::lround(at * rate)), observation.frame_count() - 1);
  const int history = static_cast<int>(
      std::clamp(std::round(options.history_seconds * rate), 1.0, moment.frame + 1.0));
  moment.past = PastAt(observation, moment.frame, history);
  MOTIONDB_ASSIGN_OR_RETURN(moment.scaled, ScaledObservation(model, moment.past));
  return moment;
}

// Returns Prediction::unknown_probability. `past` ends at the moment.
absl::StatusOr<std::optional<double>> UnknownProbabilityOf(const Model& model,
                                                           const StateSequence& past,
                                                           const PredictOptions& predicted,
                                                           const Cancelled& cancelled) {
  if (!model.recognition().window.unknown) return std::nullopt;
  RecognizeOptions options;
  options.mask = predicted.mask;
  const int width = static_cast<int>(std::lround(options.window_seconds * past.frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto windows,  // one
      Recognize(model, PastAt(past, past.frame_count() - 1, width), options, cancelled));
  return windows.front().unknown_probability;
}

absl::StatusOr<PathSearch> Search(const Model& model, const Moment& moment,
                                  const PredictOptions& options, const Cancelled& cancelled) {
  NodePathOptions search;
  search.layer = options.layer;
  search.transition_floor = options.transition_floor;
  search.mask = options.mask;
  return FindNodePaths(model, moment.scaled, search, cancelled);
}

// Predicts from stored motion. `complete`: `past` with filled gaps. `now`: its last nodes on the
// bottom layer; searched if empty.
absl::StatusOr<std::vector<PredictedFrame>> PredictByExamples(
    const Model& model, const StateSequence& past, const StateSequence& complete,
    std::vector<NodeState> now, const PredictOptions& options, const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(auto moments,
                            FindMoments(model, complete, options.transition_floor, options.mask,
                                        options.without, cancelled, std::move(now)));
  Forecaster forecaster(model, complete, std::move(moments));
  std::vector<PredictedFrame> horizons;
  for (const double seconds : options.horizon_seconds) {
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    const Forecast forecast = forecaster.At(seconds);
    PredictedFrame predicted = InWorld(past, seconds, forecast.positions);
    const PredictionConfidence& calibration = model.confidence();
    predicted.extrapolated = !forecast.has_examples || calibration.IsBeyond(seconds);
    if (!predicted.extrapolated) {
      const ExpectedError error =
          calibration.Judge(forecast.evidence, seconds, kNear_m / past.leg_length_m);
      predicted.confidence = error.probability;
      if (error.mean > 0) predicted.expected_error_m = error.mean * past.leg_length_m;
    }
    horizons.push_back(std::move(predicted));
  }
  return horizons;
}

}  // namespace

absl::Status CheckOptions(const PredictOptions& options) {
  if (!(options.history_seconds > 0 && std::isfinite(options.history_seconds))) {
    return FieldViolation("history_seconds", "expected more than 0, got {}",
                          options.history_seconds);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckTransitionFloor(options.transition_floor));
  constexpr std::size_t kMaxHorizons = 1000;
  if (options.horizon_seconds.size() > kMaxHorizons) {
    return FieldViolation("horizon_seconds", "expected at most {}, got {}", kMaxHorizons,
                          options.horizon_seconds.size());
  }
  for (std::size_t h = 0; h < options.horizon_seconds.size(); ++h) {
    const double seconds = options.horizon_seconds[h];
    if (!(seconds >= 0 && seconds <= 3600)) {
      return FieldViolation(fmt::format("horizon_seconds[{}]", h), "expected 0 to 3600, got {}",
                            seconds);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Prediction> Predict(const Model& model, const StateSequence& observation,
                                   const PredictOptions& options, const Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const Moment moment, MomentOf(model, observation, options));
  const StateSequence& past = moment.past;
  MOTIONDB_ASSIGN_OR_RETURN(const PathSearch search, Search(model, moment, options, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(auto now,
                            LastNodes(model, search, options.transition_floor, cancelled));

  Prediction prediction;
  prediction.at_seconds = moment.frame / observation.frame_rate_hz;
  prediction.layer = search.layer;
  prediction.state = now.front();
  prediction.next_nodes = NextNodes(model, search.layer, now, options.mask.get());
  if (options.method == Method::kPaper) {
    MOTIONDB_RETURN_IF_ERROR(PredictByNodes(model, past, now, options, cancelled, prediction));
    return prediction;
  }
  MOTIONDB_ASSIGN_OR_RETURN(const StateSequence complete,
                            Complete(model, search, past, moment.scaled, cancelled));
  if (search.layer != model.layer_count() || past.states.hasNaN()) now.clear();
  MOTIONDB_ASSIGN_OR_RETURN(
      prediction.horizons,
      PredictByExamples(model, past, complete, std::move(now), options, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(prediction.unknown_probability,
                            UnknownProbabilityOf(model, past, options, cancelled));
  return prediction;
}

absl::StatusOr<std::vector<PredictedFrame>> PredictFrames(const Model& model,
                                                          const StateSequence& observation,
                                                          const PredictOptions& options,
                                                          const Cancelled& cancelled) {
  if (options.method == Method::kPaper) {
    MOTIONDB_ASSIGN_OR_RETURN(auto prediction, Predict(model, observation, options, cancelled));
    return std::move(prediction.horizons);
  }
  MOTIONDB_RETURN_IF_ERROR(model.ResolveLayer(options.layer).status());
  MOTIONDB_ASSIGN_OR_RETURN(const Moment moment, MomentOf(model, observation, options));
  const StateSequence& past = moment.past;
  if (!past.states.hasNaN()) {
    return PredictByExamples(model, past, past, {}, options, cancelled);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const PathSearch search, Search(model, moment, options, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const StateSequence complete,
                            Complete(model, search, past, moment.scaled, cancelled));
  return PredictByExamples(model, past, complete, {}, options, cancelled);
}

}  // namespace motiondb::core
