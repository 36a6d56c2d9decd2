// Predicts the next nodes and marker positions of a motion (section V-A).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/estimation/estimate.h"
#include "core/inference/observation.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
class Model;

struct PredictOptions {
  Method method = Method::kBest;
  std::optional<double> at_seconds;  // absent: the end of the observation
  double history_seconds = 0.4;
  std::vector<double> horizon_seconds = {0.08, 0.16, 0.32, 0.4, 0.56, 1.0};
  int layer = 0;
  double transition_floor = 1e-6;
  std::shared_ptr<const ClipMask> mask = nullptr;  // clips to use; null: all
  FrameRange without;  // stored frames that are not used as examples, for held-out tests
};

// INVALID_ARGUMENT naming the field if an option is out of range.
absl::Status CheckOptions(const PredictOptions& options);

struct NextNode {
  int node = 0;
  double probability = 0;
  std::vector<int> clips;  // indices into Model::clips() of clips with this transition
};

struct PredictedFrame {
  double seconds = 0;
  Eigen::VectorXf marker_positions_m;  // 3 N_v, in world frame and size of the observation
  // No similar stored motion continues that long, or the horizon is longer than those whose error
  // was measured on held-out clips.
  bool extrapolated = false;
  // Probability that the mean error of the markers is below 5 cm. Absent with kPaper or if
  // extrapolated.
  std::optional<double> confidence;
  // Mean over the markers. Absent if not calibrated, with kPaper or if extrapolated.
  std::optional<double> expected_error_m;
};

struct Prediction {
  double at_seconds = 0;
  int layer = 0;
  NodeState state;
  std::vector<NextNode> next_nodes;  // the next different node, most probable first
  std::vector<PredictedFrame> horizons;
  // Probability that the observed motion has none of the stored labels, so that the prediction
  // extrapolates: as recognized in the last 0.4 s before the moment, or `history_seconds` if that
  // is less. Absent with kPaper or if not calibrated.
  std::optional<double> unknown_probability;
};

// Predicts from one moment of an observation (not scaled; the model's markers and frame rate).
// Rounds the moment to a frame. Uses only the `history_seconds` before it. INVALID_ARGUMENT if an
// option is out of range or the moment is outside the observation; CANCELLED.
absl::StatusOr<Prediction> Predict(const Model& model, const StateSequence& observation,
                                   const PredictOptions& options, const Cancelled& cancelled = {});

// Returns only the horizons of Predict. Faster: with kBest it does not search next nodes and their
// clips. Errors as Predict.
absl::StatusOr<std::vector<PredictedFrame>> PredictFrames(const Model& model,
                                                          const StateSequence& observation,
                                                          const PredictOptions& options,
                                                          const Cancelled& cancelled = {});

}  // namespace motiondb::core
