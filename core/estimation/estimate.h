// What state is it in? (sections IV-A, V-A). First where the markers are that the observation
// lacks, then where in the tree it is. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/node_path.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::core {

// Where the markers are that an observation lacks: what stored frames like it say, tied to where
// each marker was last seen and is next seen. Safe to call from any thread.
class Model;

// A frame of which markers were missing.
struct FilledFrame {
  int frame = 0;
  Eigen::VectorXf marker_positions_m;  // 3 N_v, all of them, in the observation's world and size
  // N_v: expected distance (m, root mean square) from where the marker was; 0 where it was seen.
  Eigen::VectorXf deviations_m;
};

// Which frames to fill.
enum class Fill { kLastFrame, kEveryFrame };

// Fills the frames that lack markers. `observation` is not scaled, `scaled` is the same scaled as
// the model's; `nodes` are its nodes at `layer`, one a frame, which say where to look for stored
// frames. From the 64 nearest of these the missing markers follow by regression on those seen (a
// Gaussian conditioned on them); where a marker was seen shortly before or after, what the
// regression misses there is made up for. CANCELLED.
absl::StatusOr<std::vector<FilledFrame>> FillMissing(const Model& model,
                                                     const StateSequence& observation,
                                                     const FrameMatrix& scaled, int layer,
                                                     const std::vector<std::int32_t>& nodes,
                                                     Fill fill, const Cancelled& cancelled);

// Puts filled-in positions into the observation's states; velocities stay missing.
void PutFilled(const std::vector<FilledFrame>& filled, StateSequence& observation);

// What some numbers are where others are known, from examples of both: ridge regression, which is
// the conditional mean of a Gaussian fitted to the examples. Pure; safe to call from any thread.
struct Regressed {
  Eigen::VectorXd mean;      // wanted numbers
  Eigen::VectorXd variance;  // of each about its mean, as far as the examples can tell
};

// `known` (examples x p) and `wanted` (examples x q) with weights (examples, above 0, sum 1); `at`
// is what is known now (p). `noise_variance` is that of each known number. The variance grows with
// how little the examples settle and with how far `at` lies from them. At least one example.
// O(examples^2 (p + q + examples)): for tens of examples.
Regressed Regress(const Eigen::MatrixXd& known, const Eigen::MatrixXd& wanted,
                  const Eigen::VectorXd& weights, const Eigen::VectorXd& at, double noise_variance);

// What state is it in? (sections IV-A, V-A). Safe to call from any thread.
class Model;

struct EstimateOptions {
  NodePathOptions search;
  Fill fill = Fill::kLastFrame;
};

struct Estimation {
  int layer = 0;
  std::vector<NodePath> paths;  // best first
  // Last node of the best path, with its probability given the whole observation.
  NodeState state;
  std::vector<FilledFrame> filled;  // frames that lacked markers, as far as asked for
};

// The node paths of an observation (not scaled; the model's markers and frame rate) in the global
// graph, and where its missing markers are. INVALID_ARGUMENT for settings out of range or an
// observation that does not fit; FAILED_PRECONDITION if the strict rule (floor 0) allows no path;
// CANCELLED.
absl::StatusOr<Estimation> Estimate(const Model& model, const StateSequence& observation,
                                    const EstimateOptions& options,
                                    const Cancelled& cancelled = {});

}  // namespace motiondb::core
