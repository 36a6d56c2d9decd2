// The split of a node as section III-B writes it, slowly: the exact covariance, its full
// decomposition, a comparing sort. What the fast build is measured against.
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
  Eigen::MatrixXd axes;  // a column each

  double total() const { return scatters.sum(); }
};
ExactAxes FindExactAxes(const core::FrameMatrix& states);

// Projections of states onto an axis about the mean, ascending.
std::vector<double> SortedProjections(const core::FrameMatrix& states,
                                      const Eigen::RowVectorXd& mean, const Eigen::VectorXd& axis);

// The smallest J (eq. 5, with variances) of cuts that leave either side two values; 0 if all values
// are equal.
double LeastCutCost(const std::vector<double>& sorted);

// The tree's frame ranges by splitting with these: which frames (ascending) each node has, in the
// order of branches.
std::vector<std::vector<std::int32_t>> ExactNodes(const core::FrameMatrix& states, int min_frames);

}  // namespace motiondb::tests
