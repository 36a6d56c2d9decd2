// What comes next? (section V-A). Safe to call from any thread.
#pragma once

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/estimation/estimate.h"
#include "core/inference/observation.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::core {

class Model;

struct PredictOptions {
  Method method = Method::kBest;
  std::optional<double> at_seconds;  // absent: the end of the observation
  double history_seconds = 0.4;
  std::vector<double> horizon_seconds = {0.08, 0.16, 0.32, 0.4, 0.56, 1.0};
  int layer = 0;
  double transition_floor = 1e-6;
  FrameRange without;  // stored frames that are no examples, to try the method on them
};

// INVALID_ARGUMENT naming the field if an option is out of range.
absl::Status CheckOptions(const PredictOptions& options);

struct NextNode {
  int node = 0;
  double probability = 0;
  std::vector<int> clips;  // indices into Model::clips() of those that make the transition
};

struct PredictedFrame {
  double seconds = 0;
  Eigen::VectorXf marker_positions_m;  // 3 N_v, in the observation's world and size
  // Probability that the markers are on average within 5 cm of where they will be.
  double confidence = 0;
  double expected_error_m = 0;  // mean over the markers; 0 where it is not known
};

struct Prediction {
  double at_seconds = 0;
  int layer = 0;
  NodeState state;
  std::vector<NextNode> next_nodes;  // the next different node, most probable first
  std::vector<PredictedFrame> horizons;
};

// Predicts from one moment of an observation (not scaled; the model's markers and frame rate) using
// the `history_seconds` before it and nothing after. The moment is taken at the nearest frame.
// INVALID_ARGUMENT for settings out of range or a moment outside the observation; CANCELLED.
absl::StatusOr<Prediction> Predict(const Model& model, const StateSequence& observation,
                                   const PredictOptions& options, const Cancelled& cancelled = {});

// The horizons of Predict alone, for who asks again and again: nodes and clips that may come next
// are not looked up, and a whole observation is taken down the tree to the bottom layer only.
// Errors as Predict.
absl::StatusOr<std::vector<PredictedFrame>> PredictFrames(const Model& model,
                                                          const StateSequence& observation,
                                                          const PredictOptions& options,
                                                          const Cancelled& cancelled = {});

}  // namespace motiondb::core
