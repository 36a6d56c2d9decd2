// Where the markers are that an observation lacks: what stored frames like it say, tied to where
// each marker was last seen and is next seen. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::core {

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

}  // namespace motiondb::core
