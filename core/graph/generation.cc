#include "core/graph/generation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/motion/cancellation.h"

namespace motiondb::core {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr double kRoundedAway = 1e-17;  // less than half of the last bit of 1

// Emissions relative to the greatest, as logarithms: below this nothing is left of them beside what
// the floor gives the greatest, unless the floor is smaller than any that is of use.
constexpr double kHopeless = -600;
constexpr double kLeastFloorOfUse = 1e-100;
constexpr Eigen::Index kTogether = 8;  // nodes that are looked at together: neighbours are alike

// Of one observed frame.
std::int64_t StepsOf(const TransitionGraph& graph,
                     const Eigen::Ref<const EmissionMatrix>& emission) {
  return emission.cols() + graph.edge_count();
}

// log(e^a + e^b).
double LogAdd(double a, double b) {
  const double high = std::max(a, b);
  return high == kNever ? kNever : high + std::log1p(std::exp(std::min(a, b) - high));
}

// Multiplies `forward` with exp(emission - peak). Most nodes of a large layer are hopeless, and
// their exponentials would be most of the work: they are 0, where all that are looked at together
// are.
void Weigh(const Eigen::Ref<const Eigen::RowVectorXd>& emission, double peak, double hopeless,
           Eigen::VectorXd& forward) {
  const Eigen::Index nodes = forward.size();
  const Eigen::Index whole = nodes / kTogether * kTogether;
  for (Eigen::Index n = 0; n < whole; n += kTogether) {
    auto part = forward.segment<kTogether>(n).array();
    const auto relative = emission.segment<kTogether>(n).transpose().array() - peak;
    if (relative.maxCoeff() < hopeless) {
      part.setZero();
    } else {
      part *= relative.exp();
    }
  }
  const Eigen::Index rest = nodes - whole;
  forward.tail(rest).array() *= (emission.tail(rest).transpose().array() - peak).exp();
}

// The strict rule (floor 0) with every number a logarithm: slower, but no path is lost however
// small its share at some frame. Turns `forward` into the logarithms at the last frame.
double LogGenerationOfSeen(const TransitionGraph& graph,
                           const Eigen::Ref<const EmissionMatrix>& emission,
                           Eigen::VectorXd& forward, Patience& patience) {
  forward = emission.row(0).transpose();
  for (Eigen::Index t = 1; t < emission.rows(); ++t) {
    if (patience.IsOver(StepsOf(graph, emission))) return kNever;
    Eigen::VectorXd arriving = Eigen::VectorXd::Constant(emission.cols(), kNever);
    for (int from = 0; from < static_cast<int>(emission.cols()); ++from) {
      const double log_leaving = std::log(static_cast<double>(graph.row_sum(from)));
      for (const Edge& edge : graph.row(from)) {
        arriving[edge.to] =
            LogAdd(arriving[edge.to], forward[from] + std::log(edge.count) - log_leaving);
      }
    }
    forward = arriving + emission.row(t).transpose();
  }
  double sum = kNever;
  for (double log : forward) sum = LogAdd(sum, log);
  return sum;
}

}  // namespace

double LogGeneration(const TransitionGraph& graph, const Eigen::Ref<const EmissionMatrix>& emission,
                     double transition_floor, Eigen::VectorXd* last, const Cancelled& cancelled) {
  Patience patience(cancelled);
  const Eigen::Index nodes = emission.cols();
  Eigen::VectorXd forward = Eigen::VectorXd::Ones(nodes);  // scaled to sum to 1 after each frame
  Eigen::VectorXd arriving(nodes);
  double log_probability = 0;
  if (last != nullptr) *last = Eigen::VectorXd::Zero(nodes);
  if (transition_floor == 0 && emission.rows() > 0) {
    log_probability = LogGenerationOfSeen(graph, emission, forward, patience);
    if (last != nullptr && log_probability > kNever) {
      *last = (forward.array() - log_probability).exp();
    }
    return log_probability;
  }

  // What leaves a node with less is rounded away where it arrives, for at least the floor is there.
  const double negligible = kRoundedAway * transition_floor;
  const double hopeless = transition_floor < kLeastFloorOfUse ? kNever : kHopeless;
  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    if (patience.IsOver(StepsOf(graph, emission))) return kNever;
    if (t > 0) {
      // Every pair has the floor; what was seen replaces it.
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
    if (!(peak > kNever)) return kNever;
    Weigh(emission.row(t), peak, hopeless, forward);
    const double sum = forward.sum();
    if (!(sum > 0)) return kNever;
    forward /= sum;
    log_probability += std::log(sum) + peak;
  }
  if (last != nullptr) *last = forward;
  return log_probability;
}

double LogGenerationAmong(const TransitionGraph& graph,
                          std::span<const std::vector<LikelyNode>> frames, double floor,
                          std::vector<double>& scratch) {
  std::vector<double> before;  // of the nodes of the frame before, summing to 1
  std::vector<double> forward;
  double log_probability = 0;
  for (std::size_t t = 0; t < frames.size(); ++t) {
    // What was seen beyond the floor that every pair has.
    for (std::size_t i = 0; i < before.size(); ++i) {
      const int from = frames[t - 1][i].node;
      const double share = before[i] / static_cast<double>(graph.row_sum(from));
      for (const Edge& edge : graph.row(from)) {
        scratch[edge.to] += share * edge.count - before[i] * floor;
      }
    }
    double peak = kNever;
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
    for (std::size_t i = 0; i < before.size(); ++i) {
      for (const Edge& edge : graph.row(frames[t - 1][i].node)) scratch[edge.to] = 0;
    }
    before.swap(forward);
  }
  return log_probability;
}

}  // namespace motiondb::core
