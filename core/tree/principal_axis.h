// The first principal axis of a node's states (section III-B, eq. 3): the first left singular
// vector of the centred dimensions-by-frames matrix, which is the leading eigenvector of its
// scatter matrix; and the eigenvectors of the tridiagonal matrices by which the Lanczos method
// finds it. Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

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

struct TridiagonalTop {
  double value = 0;
  Eigen::VectorXd vector;  // unit; small components are known to as many digits as large ones
};

// For the matrix with `diagonal` (n >= 1 numbers) and `beside` it (the first n - 1 are read, none
// of them 0). The eigenvalue by Laguerre's method from above, which closes in from one side and
// triples its digits; the vector from the factorisations from both ends, joined where they meet
// best.
TridiagonalTop TopOfTridiagonal(std::span<const double> diagonal, std::span<const double> beside);

// The principal axis of a node's frames, at a cost of a few readings of them.

// A node's states, one after the other. Not owned.
struct NodeRows {
  const float* data = nullptr;
  int count = 0;  // at least 1
  int dimensions = 0;

  const float* row(int r) const { return data + static_cast<std::ptrdiff_t>(r) * dimensions; }
};

// Nodes of at most this many frames get their axis to kTightTolerance, larger ones to
// kLooseTolerance.
inline constexpr int kTightFrames = 16384;
inline constexpr double kTightTolerance = 1e-6;
inline constexpr double kLooseTolerance = 1e-3;

struct NodeAxis {
  Eigen::VectorXd mean;
  PrincipalAxis principal;  // of the scatter matrix, the sum of c c^T over the centred states c
};

// Mean and principal axis. The axis's residual |S a - v a| / v is at most kTightTolerance or
// kLooseTolerance, beside rounding (about 1e-7 times the sum of |x|^2, over v): so v, the scatter
// along the axis, is within that part of an eigenvalue of S, and the sine of the angle to the true
// axis at most residual * v / (v - v2), v2 being the scatter along the second axis. Nodes of some
// thousand frames start from the dimension that varies most; larger ones from the axis of some
// thousand of their frames, evenly spread, which is also what tells apart axes of nearly the same
// scatter. `centred` is scratch, and keeps its memory for the next call. The same rows give the
// same axis, bit for bit, with any `parallel`. O(frames * dimensions) a product with S.
NodeAxis FindNodeAxis(const NodeRows& rows, std::vector<float>& centred,
                      const ParallelFor& parallel);

}  // namespace motiondb::core
