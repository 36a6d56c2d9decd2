// Where the markers will be by the graph alone, as in the paper (section V-A): the nodes the motion
// may be in spread along the global graph, and each looks as its mean. Safe to call from any
// thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/inference/lattice.h"

namespace motiondb::core {

class Model;

class NodeForecaster {
 public:
  // `now`: the nodes of `layer` that the motion may be in; probabilities sum to 1.
  NodeForecaster(const Model& model, int layer, const std::vector<NodeState>& now);

  // Marker positions (3 N_v, leg lengths) after `seconds`, in the reference frame of now: expected
  // means of the nodes, moved on with the hips' mean velocities. Moments must ascend. Where no node
  // goes on, the motion stays. Once cancelled it returns early, with what is of no use.
  Eigen::RowVectorXf At(double seconds, const Cancelled& cancelled = {});

 private:
  void Step();
  // Expected mean state, 6 N_v, not scaled.
  Eigen::RowVectorXf Mean() const;

  const Model& model_;
  const int layer_;
  std::vector<double> probability_;  // of each node of the layer
  Eigen::Vector2f moved_ = Eigen::Vector2f::Zero();
  int frames_ = 0;
};

}  // namespace motiondb::core
