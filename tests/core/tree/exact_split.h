// Slow reference for the split of a node (section III-B): exact covariance, full
// eigendecomposition, comparison sort.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::tests {

// Eigenvalues (ascending) and eigenvectors of the scatter matrix of states (frames x dimensions).
struct ExactAxes {
  Eigen::RowVectorXd mean;
  Eigen::VectorXd scatters;
  Eigen::MatrixXd axes;  // one per column

  double total() const { return scatters.sum(); }
};
ExactAxes FindExactAxes(const core::FrameMatrix& states);

// Returns projections of states onto an axis through the mean, ascending.
std::vector<double> SortedProjections(const core::FrameMatrix& states,
                                      const Eigen::RowVectorXd& mean, const Eigen::VectorXd& axis);

// Returns the minimum J (eq. 5, with variances) over cuts with at least two values on each side; 0
// if all values are equal.
double MinCutCost(const std::vector<double>& sorted);

// Splits recursively with these functions. Returns each node's frames (ascending) in the order of
// branches.
std::vector<std::vector<std::int32_t>> ExactNodes(const core::FrameMatrix& states, int min_frames);

}  // namespace motiondb::tests
