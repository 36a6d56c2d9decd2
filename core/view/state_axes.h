// Principal axes of all states of a model (Figs. 6 to 10), and the frames in them.
#pragma once

#include <Eigen/Core>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

class Model;

inline constexpr int kReportedAxes = 6;
inline constexpr int kDrawnAxes = 3;

// Immutable. Shared by threads.
struct StateAxes {
  Eigen::VectorXd mean;  // dimensions: the origin of the axes
  // dimensions x at most kReportedAxes: unit axes, by falling variance. The component of each axis
  // with the largest magnitude (ties: the first) is positive.
  Eigen::MatrixXd axes;
  // Fraction (0 to 1) of the total variance along each axis; 0 if all states are equal.
  Eigen::VectorXd variance_fractions;
  // frames x kDrawnAxes: the scaled states in the first axes. 0 for axes that do not exist.
  FrameMatrix projections;
};

// Returns the principal axes of the scaled states (frames x dimensions): eigenvectors of their
// covariance, which is summed in single precision over blocks of frames and in double over blocks.
// The result is bitwise identical for any `parallel`. O(frames * dimensions^2 + dimensions^3);
// memory: 12 bytes for each frame, and 40 for each pair of dimensions. CANCELLED; all threads call
// `cancelled`.
absl::StatusOr<StateAxes> FindStateAxes(const Eigen::Ref<const FrameMatrix>& states,
                                        const ParallelFor& parallel = RunSerially,
                                        const Cancelled& cancelled = {});

// Makes the component of the vector with the largest magnitude (ties: the first) positive.
template <typename Vector>
void FixSign(Vector&& vector) {
  Eigen::Index largest = 0;
  vector.cwiseAbs().maxCoeff(&largest);
  if (vector[largest] < 0) vector = -vector;
}

}  // namespace motiondb::core
