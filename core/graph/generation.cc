#include "core/graph/generation.h"

#include <cmath>
#include <limits>

namespace motiondb::core {

double LogGeneration(const TransitionGraph& graph, const Eigen::Ref<const EmissionMatrix>& emission,
                     double transition_floor, Eigen::VectorXd* last) {
  constexpr double kNever = -std::numeric_limits<double>::infinity();
  const Eigen::Index nodes = emission.cols();
  Eigen::VectorXd forward = Eigen::VectorXd::Ones(nodes);  // scaled to sum to 1 after each frame
  Eigen::VectorXd arriving(nodes);
  double log_probability = 0;
  if (last != nullptr) *last = Eigen::VectorXd::Zero(nodes);

  for (Eigen::Index t = 0; t < emission.rows(); ++t) {
    if (t > 0) {
      // Every pair has the floor; what was seen replaces it.
      arriving.setConstant(transition_floor * forward.sum());
      for (Eigen::Index from = 0; from < nodes; ++from) {
        if (forward[from] == 0) continue;
        const auto leaving = static_cast<double>(graph.row_sum(static_cast<int>(from)));
        for (const Edge& edge : graph.row(static_cast<int>(from))) {
          arriving[edge.to] += forward[from] * (edge.count / leaving - transition_floor);
        }
      }
      forward = arriving.cwiseMax(0);
    }
    const double peak = emission.row(t).maxCoeff();
    if (!(peak > kNever)) return kNever;
    forward.array() *= (emission.row(t).transpose().array() - peak).exp();
    const double sum = forward.sum();
    if (!(sum > 0)) return kNever;
    forward /= sum;
    log_probability += std::log(sum) + peak;
  }
  if (last != nullptr) *last = forward;
  return log_probability;
}

}  // namespace motiondb::core
