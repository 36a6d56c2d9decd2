// The largest eigenvalue of a symmetric tridiagonal matrix and its eigenvector, in time
// proportional to its size: the Lanczos method asks after every step. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <span>

namespace motiondb::core {

struct TridiagonalTop {
  double value = 0;
  Eigen::VectorXd vector;  // unit; small components are known to as many digits as large ones
};

// For the matrix with `diagonal` (n >= 1 numbers) and `beside` it (the first n - 1 are read, none
// of them 0). The eigenvalue by Laguerre's method from above, which closes in from one side and
// triples its digits; the vector from the factorisations from both ends, joined where they meet
// best.
TridiagonalTop TopOfTridiagonal(std::span<const double> diagonal, std::span<const double> beside);

}  // namespace motiondb::core
