#include "core/graph/generation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/motion/cancellation.h"

namespace motiondb::core {
namespace {

constexpr double kLogZero = -std::numeric_limits<double>::infinity();
constexpr double kRoundedAway = 1e-17;  // less than half an ulp of 1

// Log emissions relative to the maximum. Below kNegligibleEmission, a node's share is negligible
// next to what the floor transfers to the most likely node, unless the floor is extremely small.
constexpr double kNegligibleEmission = -600;
constexpr double kMinUsefulFloor = 1e-100;
constexpr Eigen::Index kBlockNodes = 8;  // nodes of a block: neighbours are similar

// Steps for one observed frame.
std::int64_t StepsOf(const TransitionGraph& graph,
                     const Eigen::Ref<const EmissionMatrix>& emission) {
  return emission.cols() + graph.edge_count();
}

// log(e^a + e^b).
double LogAdd(double a, double b) {
  const double high = std::max(a, b);
  return high == kLogZero ? kLogZero : high + std::log1p(std::exp(std::min(a, b) - high));
}

// Multiplies `forward` by exp(emission - peak). Sets blocks of nodes to 0 if all their emissions
// are negligible: most nodes of a large layer are, and exponentials dominate the cost.
void Weigh(const Eigen::Ref<const Eigen::RowVectorXd>& emission, double peak,
           double negligible_emission, Eigen::VectorXd& forward) {
  const Eigen::Index nodes = forward.size();
  const Eigen::Index whole = nodes / kBlockNodes * kBlockNodes;
  for (Eigen::Index n = 0; n < whole; n += kBlockNodes) {
    auto part = forward.segment<kBlockNodes>(n).array();
    const auto relative = emission.segment<kBlockNodes>(n).transpose().array() - peak;
    if (relative.maxCoeff() < negligible_emission) {
      part.setZero();
    } else {
      part *= relative.exp();
    }
  }
  const Eigen::Index rest = nodes - whole;
  forward.tail(rest).array() *= (emission.tail(rest).transpose().array() - peak).exp();
}

// The strict rule (floor 0), entirely in logarithms: slower, but no path underflows. `forward`
// becomes the log probabilities at the last frame.
double LogGenerationOfSeen(const TransitionGraph& graph,
                           const Eigen::Ref<const EmissionMatrix>& emission,
                           Eigen::VectorXd& forward, ThrottledCancellation& cancellation) {
  forward = emission.row(0).transpose();
  for (Eigen::Index t = 1; t < emission.rows(); ++t) {
    if (cancellation.cancelled(StepsOf(graph, emission))) return kLogZero;
    Eigen::VectorXd arriving = Eigen::VectorXd::Constant(emission.cols(), kLogZero);
    for (int from = 0; from < static_cast<int>(emission.cols()); ++from) {
      const double log_leaving = std::log(static_cast<double>(graph.row_sum(from)));
      for (const Edge& edge : graph.row(from)) {
        arriving[edge.to] =
            LogAdd(arriving[edge.to], forward[from] + std::log(edge.count) - log_leaving);
      }
    }
    forward = arriving + emission.row(t).transpose();
  }
  double sum = kLogZero;
  for (double log : forward) sum = LogAdd(sum, log);
  return sum;
}

}  // namespace

double LogGeneration(const TransitionGraph& graph, const Eigen::Ref<const EmissionMatrix>& emission,
                     double transition_floor, Eigen::VectorXd* last, const Cancelled& cancelled) {
  ThrottledCancellation cancellation(cancelled);
  const Eigen::Index nodes = emission.cols();
  Eigen::VectorXd forward = Eigen::VectorXd::Ones(nodes);  // scaled to sum to 1 after each frame
  Eigen::VectorXd arriving(nodes);
  double log_probability = 0;
  if (last != nullptr) *last = Eigen::VectorXd::Zero(nodes);
  if (transition_floor == 0 && emission.rows() > 0) {
    log_probability = LogGenerationOfSeen(graph, emission, forward, cancellation);
    if (last != nullptr && log_probability > kLogZero) {
      *last = (forward.array() - log_probability).exp();
    }
    return log_probability;
  }

  // A smaller probability of a node vanishes by rounding where it arrives, next to the floor.
  const double negligible = kRoundedAway * transition_floor;
  const double negligible_emission =
      transition_floor < kMinUsefulFloor ? kLogZero : kNegligibleEmission;
  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    if (cancellation.cancelled(StepsOf(graph, emission))) return kLogZero;
    if (t > 0) {
      // Every pair has the floor; counted transitions replace it.
      arriving.setConstant(transition_floor * forward.sum());
      for (Eigen::Index from = 0; from < nodes; ++from) {
        if (forward[from] < negligible) continue;
        const auto leaving = static_cast<double>(graph.row_sum(static_cast<int>(from)));
        for (const Edge& edge : graph.row(static_cast<int>(from))) {
          arriving[edge.to] += forward[from] * (edge.count / leaving - transition_floor);
        }
      }
      forward = arriving.cwiseMax(0);
    }
    const double peak = emission.row(t).maxCoeff();
    if (!(peak > kLogZero)) return kLogZero;
    Weigh(emission.row(t), peak, negligible_emission, forward);
    const double sum = forward.sum();
    if (!(sum > 0)) return kLogZero;
    forward /= sum;
    log_probability += std::log(sum) + peak;
  }
  if (last != nullptr) *last = forward;
  return log_probability;
}

double LogGenerationOfCandidates(const TransitionGraph& graph,
                                 std::span<const std::vector<LikelyNode>> frames, double floor,
                                 std::vector<double>& scratch) {
  std::vector<double> previous;  // probabilities of the previous frame's nodes, sum 1
  std::vector<double> forward;
  double log_probability = 0;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    // Counted transitions, minus the floor that every pair has.
    for (std::size_t i = 0; i < previous.size(); ++i) {
      const int from = frames[t - 1][i].node;
      const double share = previous[i] / static_cast<double>(graph.row_sum(from));
      for (const Edge& edge : graph.row(from)) {
        scratch[edge.to] += share * edge.count - previous[i] * floor;
      }
    }
    double peak = kLogZero;
    for (const LikelyNode& likely : frames[t]) peak = std::max<double>(peak, likely.log_density);
    forward.clear();
    double sum = 0;
    for (const LikelyNode& likely : frames[t]) {
      const double arriving = t == 0 ? 1 : std::max(0.0, floor + scratch[likely.node]);
      forward.push_back(arriving * std::exp(likely.log_density - peak));
      sum += forward.back();
    }
    for (double& probability : forward) probability /= sum;
    log_probability += std::log(sum) + peak;
    for (std::size_t i = 0; i < previous.size(); ++i) {
      for (const Edge& edge : graph.row(frames[t - 1][i].node)) scratch[edge.to] = 0;
    }
    previous.swap(forward);
  }
  return log_probability;
}

}  // namespace motiondb::core
