// Estimates the current state (sections IV-A, V-A): node paths in the tree, and positions of
// missing markers.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/node_path.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
class Model;

// A frame with missing markers, filled in.
struct FilledFrame {
  int frame = 0;
  Eigen::VectorXf marker_positions_m;  // 3 N_v, all markers, in the observation's world and size
  // N_v: expected error (m, rms); 0 for a marker that was seen.
  Eigen::VectorXf deviations_m;
};

// Which frames to fill.
enum class Fill { kLastFrame, kEveryFrame };

// Fills frames with missing markers. `observation`: not scaled; `scaled`: the same, scaled as the
// model's; `nodes`: its node at `layer` in each frame, which selects the stored frames. Regression
// on the markers seen (a conditional Gaussian), fitted to the 64 nearest stored frames, yields the
// missing ones. `mask`: the clips to use, null: all. If a marker is seen shortly before or after,
// the regression's error there corrects the estimate. CANCELLED.
absl::StatusOr<std::vector<FilledFrame>> FillMissing(const Model& model,
                                                     const StateSequence& observation,
                                                     const FrameMatrix& scaled, int layer,
                                                     const std::vector<std::int32_t>& nodes,
                                                     Fill fill, const ClipMask* mask,
                                                     const Cancelled& cancelled);

// Writes filled positions to the observation's states; their velocities stay missing.
void ApplyFilled(const std::vector<FilledFrame>& filled, StateSequence& observation);

// Ridge regression: the conditional mean of a Gaussian fitted to examples.
struct Regressed {
  Eigen::VectorXd mean;      // of the wanted values
  Eigen::VectorXd variance;  // of each value about its mean, estimated from the examples
};

// `known` (examples x p), `wanted` (examples x q), weights (examples, > 0, sum 1); at least one
// example. `at` (p): the current known values, each with variance `noise_variance`. The variance of
// the result grows with the unexplained part of the examples and with the distance of `at` from
// them. O(examples^2 (p + q + examples)): for tens of examples.
Regressed Regress(const Eigen::MatrixXd& known, const Eigen::MatrixXd& wanted,
                  const Eigen::VectorXd& weights, const Eigen::VectorXd& at, double noise_variance);

struct EstimateOptions {
  NodePathOptions search;  // with the clips to use
  Fill fill = Fill::kLastFrame;
};

struct Estimation {
  int layer = 0;
  std::vector<NodePath> paths;  // best first
  // Last node of the best path, with its probability given the whole observation.
  NodeState state;
  std::vector<FilledFrame> filled;  // frames with missing markers, by EstimateOptions::fill
};

// Returns the node paths of an observation (not scaled; the model's markers and frame rate) in the
// global graph, and its missing markers. INVALID_ARGUMENT for options out of range or an
// observation that does not fit; FAILED_PRECONDITION if the strict rule (floor 0) allows no path;
// CANCELLED.
absl::StatusOr<Estimation> Estimate(const Model& model, const StateSequence& observation,
                                    const EstimateOptions& options,
                                    const Cancelled& cancelled = {});

}  // namespace motiondb::core
