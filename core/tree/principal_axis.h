// The first principal axis of a node's states (section III-B, eq. 3): the first left singular
// vector of the centred dimensions-by-frames matrix, which is the leading eigenvector of its
// covariance.
#pragma once

#include <Eigen/Core>

namespace motiondb::core {

// Leading unit eigenvector of a symmetric positive semi-definite matrix (dimensions x dimensions,
// lower triangle read), by the Lanczos method with full reorthogonalisation; the residual |C v - l
// v| is at most 1e-9 l, or the full decomposition is used. Its sign is fixed: the component of
// largest magnitude (the first of equals) is positive. A zero matrix gives the first unit vector.
// O(dimensions^2) a step.
Eigen::VectorXd PrincipalAxis(const Eigen::MatrixXd& covariance);

}  // namespace motiondb::core
