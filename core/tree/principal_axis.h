// The first principal axis of a node's states (section III-B, eq. 3): the first left singular
// vector of the centred dimensions-by-frames matrix, which is the leading eigenvector of its
// scatter matrix. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace motiondb::core {

// Sets y to C x for a symmetric positive semi-definite C: dimensions numbers each.
using SymmetricProduct = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

struct PrincipalAxis {
  Eigen::VectorXd axis;  // unit; its component of largest magnitude (the first of equals) is > 0
  double variance = 0;   // axis^T C axis
  double residual = 0;   // |C axis - variance axis| / variance, 0 where C is zero
  int products = 0;      // how often C was multiplied with
};

// The leading eigenvector of C, by the Lanczos method with full reorthogonalisation from `start`
// (not zero), until the residual is at most `tolerance`. Then an eigenvalue of C lies within
// tolerance * variance of `variance`, and the sine of the angle to the true axis is at most
// residual * variance / (variance - l2), l2 being C's second eigenvalue. The start must not be
// orthogonal to the axis. A C that maps the start to zero gives the start. O(dimensions * products)
// a step beside the product, and at most `dimensions` steps.
PrincipalAxis FindPrincipalAxis(const SymmetricProduct& product, const Eigen::VectorXd& start,
                                double tolerance);

}  // namespace motiondb::core
