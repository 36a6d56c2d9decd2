#include "core/prediction/node_forecast.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"
#include "core/motion/patience.h"

namespace motiondb::core {

NodeForecaster::NodeForecaster(const Model& model, int layer, const std::vector<NodeState>& now)
    : model_(model),
      layer_(layer),
      probability_(static_cast<std::size_t>(model.tree().node_count(layer)), 0.0) {
  for (const NodeState& state : now) probability_[state.node] = state.probability;
}

Eigen::RowVectorXf NodeForecaster::Mean() const {
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(model_.states().cols());
  for (std::size_t node = 0; node < probability_.size(); ++node) {
    if (probability_[node] <= 0) continue;
    const int branch = model_.tree().branch(layer_, static_cast<int>(node));
    mean += probability_[node] * model_.gaussians().means().row(branch).cast<double>();
  }
  return mean.cast<float>().cwiseProduct(model_.scale().divisor);
}

void NodeForecaster::Step() {
  const Eigen::RowVectorXf mean = Mean();
  const Landmarks& hips = model_.marker_set().landmarks;
  const Eigen::RowVector2f velocity =
      (mean.segment<2>(6 * hips.left_hip + 3) + mean.segment<2>(6 * hips.right_hip + 3)) / 2;
  moved_ += velocity.transpose() / static_cast<float>(model_.settings().frame_rate_hz);
  const TransitionGraph& graph = model_.global_graph(layer_);
  std::vector<double> next(probability_.size(), 0.0);
  double total = 0;
  for (std::size_t node = 0; node < probability_.size(); ++node) {
    const auto leaving = static_cast<double>(graph.row_sum(static_cast<int>(node)));
    if (probability_[node] <= 0 || leaving <= 0) continue;
    for (const Edge& edge : graph.row(static_cast<int>(node))) {
      next[edge.to] += probability_[node] * edge.count / leaving;
    }
    total += probability_[node];
  }
  if (total <= 0) return;
  for (double& p : next) p /= total;
  probability_ = std::move(next);
}

Eigen::RowVectorXf NodeForecaster::At(double seconds, const Cancelled& cancelled) {
  const auto frames = static_cast<int>(std::lround(seconds * model_.settings().frame_rate_hz));
  Patience patience(cancelled);
  const auto step = std::ssize(probability_) + model_.global_graph(layer_).edge_count();
  for (; frames_ < frames && !patience.IsOver(step); ++frames_) Step();
  const Eigen::RowVectorXf mean = Mean();
  Eigen::RowVectorXf positions(mean.size() / 2);
  for (Eigen::Index m = 0; m < positions.size() / 3; ++m) {
    positions.segment<3>(3 * m) = mean.segment<3>(6 * m);
    positions.segment<2>(3 * m) += moved_.transpose();
  }
  return positions;
}

}  // namespace motiondb::core
