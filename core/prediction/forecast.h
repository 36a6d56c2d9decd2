// Where the markers will be: stored motion like the last moments observed, weighed by a local
// Gaussian process around a linear prior, on the observed body's own bones. Safe to call from any
// thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/lattice.h"
#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "core/model/motion_prior.h"
#include "core/model/prediction_confidence.h"
#include "core/motion/cancellation.h"
#include "core/motion/matrix.h"
#include "core/motion/states.h"

namespace motiondb::core {

struct ExemplarWeights {
  Eigen::VectorXd weights;  // examples; signed, and they need not sum to 1
  double variance = 1;      // of the process at the query: 0 where the examples tell all, 1 nothing
};

// Kriging with the kernel exp(-distance / kernel_length) and `noise` beside a variance of 1: keys
// of the examples (examples x dimensions), key of the query, distances Euclidean. O(examples^2
// (dimensions + examples)).
ExemplarWeights WeighExemplars(const FrameMatrix& keys, const Eigen::RowVectorXf& query,
                               double kernel_length, double noise);

class Model;

// A moment of stored motion, as it was or in a mirror.
struct StoredMoment {
  int frame = 0;
  bool mirrored = false;
};

struct Forecast {
  Eigen::RowVectorXf positions;  // 3 N_v, leg lengths, in the reference frame of the moment
  // What tells how good it is: the variance of the process (1 where no example is like the moment),
  // how much the examples' futures differ from it on average, and how far a marker moved over the
  // last 0.12 s.
  PredictionEvidence evidence;
};

class Forecaster {
 public:
  // `past` ends at the moment and lacks no marker; the model and it must outlive the forecaster.
  // `moments` are stored moments to choose examples from. `prior`: another than the model's.
  Forecaster(const Model& model, const StateSequence& past, std::vector<StoredMoment> moments,
             const MotionPrior* prior = nullptr);

  // Of the examples, those whose clips go on so long count. `seconds` >= 0.
  Forecast At(double seconds);

 private:
  // What the prior looks at before one of moments_.
  const Eigen::RowVectorXf& FeaturesOf(std::size_t i);
  // Picks and weighs the nearest moments that are followed by so many seconds.
  void Weigh(double seconds);
  // How an example's markers move on (3 N_v, leg lengths).
  Eigen::RowVectorXf Future(const StoredMoment& moment, double seconds) const;

  const Model& model_;
  const MotionPrior& prior_;
  FrameMatrix history_;
  Eigen::RowVectorXf key_;
  Eigen::RowVectorXf features_;
  double speed_ = 0;
  std::vector<StoredMoment> moments_;            // nearest first
  std::vector<Eigen::RowVectorXf> keys_;         // of each
  std::vector<Eigen::RowVectorXf> features_of_;  // of each, empty until they are asked for
  std::vector<std::size_t> chosen_;              // of moments_, those weighed last
  ExemplarWeights weights_;                      // of these
};

// Stored moments to forecast from: those most like the last frame of `past` among the frames that
// the tree takes it to, and the same of its mirror image where the markers have sides. Frames in
// `without` are passed over. `known`, where given, are the LastNodes of `past` on the bottom layer,
// so that they are not looked for again. Errors as FindNodePaths.
absl::StatusOr<std::vector<StoredMoment>> FindMoments(const Model& model, const StateSequence& past,
                                                      double transition_floor, FrameRange without,
                                                      const Cancelled& cancelled,
                                                      std::vector<NodeState> known = {});

// Where the markers will be by the graph alone, as in the paper (section V-A): the nodes the motion
// may be in spread along the global graph, and each looks as its mean. Safe to call from any
// thread.
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
