// Predicted marker positions: a local Gaussian process over similar stored moments, with a linear
// prior mean; the observed bone lengths are kept.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "core/model/answer_calibration.h"
#include "core/model/motion_prior.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/motion/states.h"

namespace motiondb::core {

struct ExemplarWeights {
  Eigen::VectorXd weights;  // examples; signed, and they need not sum to 1
  double variance = 1;      // of the process at the query: 0 certain, 1 no information
};

// Returns the weights of a Gaussian process (kriging) with the kernel exp(-distance /
// kernel_length), Euclidean distances, variance 1 and the noise variance `noise`. keys: examples x
// dimensions. O(examples^2 (dimensions + examples)).
ExemplarWeights WeighExemplars(const FrameMatrix& keys, const Eigen::RowVectorXf& query,
                               double kernel_length, double noise);

class ClipMask;
class Model;

// A moment of stored motion, or its mirror image.
struct StoredMoment {
  int frame = 0;
  bool mirrored = false;
};

struct Forecast {
  Eigen::RowVectorXf positions;  // 3 N_v, leg lengths, in the reference frame of the moment
  // Inputs of the error model: the variance of the process, the mean distance of the examples'
  // futures from the forecast, and the mean movement of the markers in the last 0.12 s.
  PredictionEvidence evidence;
  bool has_examples = false;  // similar stored motion continues that long
};

class Forecaster {
 public:
  // `past` ends at the moment and has no missing markers. Examples are chosen from `moments`. If
  // `prior` is null, the prior of the model is used. The model and `past` must outlive this.
  Forecaster(const Model& model, const StateSequence& past, std::vector<StoredMoment> moments,
             const MotionPrior* prior = nullptr);

  // Returns the forecast for `seconds` (>= 0) after the moment. Uses only examples whose clips
  // continue that long.
  Forecast At(double seconds);

 private:
  // Returns the inputs of the prior for moments_[i].
  const Eigen::RowVectorXf& FeaturesOf(std::size_t i);
  // Chooses and weights the nearest moments that are followed by `seconds` of motion.
  void ChooseExamples(double seconds);
  // Returns the displacement of an example's markers (3 N_v, leg lengths).
  Eigen::RowVectorXf Future(const StoredMoment& moment, double seconds) const;

  const Model& model_;
  const MotionPrior& prior_;
  FrameMatrix history_;
  Eigen::RowVectorXf key_;
  Eigen::RowVectorXf features_;
  double speed_ = 0;
  std::vector<StoredMoment> moments_;            // nearest first
  std::vector<Eigen::RowVectorXf> keys_;         // one for each moment
  std::vector<Eigen::RowVectorXf> features_of_;  // one for each moment; empty until needed
  std::vector<std::size_t> chosen_;              // indices into moments_
  ExemplarWeights weights_;                      // of the chosen moments
};

// Returns the stored moments most similar to the last frame of `past`, among the frames of the
// nodes that the tree finds for it, and those most similar to its mirror image if the markers have
// sides. Uses the clips that `mask` allows (null: all), without the frames in `without`. `known`:
// LastNodes of `past` on the bottom layer; searched if empty. Errors as FindNodePaths.
absl::StatusOr<std::vector<StoredMoment>> FindMoments(const Model& model, const StateSequence& past,
                                                      double transition_floor,
                                                      std::shared_ptr<const ClipMask> mask,
                                                      FrameRange without,
                                                      const Cancelled& cancelled,
                                                      std::vector<NodeState> known = {});

// Prediction with the global graph alone, as in the paper (section V-A): the distribution over
// nodes propagates along the graph, and each node has its mean pose.
class NodeForecaster {
 public:
  // `now`: possible current nodes of `layer`; their probabilities sum to 1. `mask`: the clips to
  // use; null: all. The model and the mask must outlive this.
  NodeForecaster(const Model& model, int layer, const std::vector<NodeState>& now,
                 const ClipMask* mask = nullptr);

  // Returns the marker positions (3 N_v, leg lengths) after `seconds`, in the current reference
  // frame: the expected node mean, moved by the hips' mean velocities. `seconds` must not decrease
  // from call to call. If no node has a successor, the distribution does not change. If
  // cancelled, returns early with an invalid result.
  Eigen::RowVectorXf At(double seconds, const Cancelled& cancelled = {});

 private:
  void Step();
  // Returns the expected mean state (6 N_v, not scaled).
  Eigen::RowVectorXf Mean() const;

  const Model& model_;
  const int layer_;
  const TransitionGraph& graph_;
  std::vector<double> probability_;  // of each node of the layer
  Eigen::Vector2f moved_ = Eigen::Vector2f::Zero();
  int frames_ = 0;
};

}  // namespace motiondb::core
