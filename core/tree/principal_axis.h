// The first principal axis of a node's states (section III-B, eq. 3): the first left singular
// vector of the centred dimensions-by-frames matrix, i.e. the leading eigenvector of its scatter
// matrix, by the Lanczos method; and eigenvectors of tridiagonal matrices.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

// Sets y to C x for a symmetric positive semi-definite C; x and y have `dimensions` numbers.
using SymmetricProduct = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

struct PrincipalAxis {
  Eigen::VectorXd axis;  // unit; its component of largest magnitude (ties: the first) is > 0
  double variance = 0;   // axis^T C axis
  double residual = 0;   // |C axis - variance axis| / variance; 0 if C is zero
  int products = 0;      // number of products with C
};

// Returns the leading eigenvector of C, by the Lanczos method with full reorthogonalisation from
// `start` (not zero), until the residual is at most `tolerance`. Then an eigenvalue of C is within
// tolerance * variance of `variance`, and the sine of the angle to the true axis is at most
// residual * variance / (variance - l2), with l2 the second eigenvalue of C. The start must not be
// orthogonal to the axis. If C maps the start to zero, returns the start. O(dimensions * products)
// for each step plus the product; at most `dimensions` steps.
PrincipalAxis FindPrincipalAxis(const SymmetricProduct& product, const Eigen::VectorXd& start,
                                double tolerance);

struct TridiagonalTop {
  double value = 0;
  Eigen::VectorXd vector;  // unit; small components are as accurate as large ones
};

// Returns the largest eigenvalue and its vector of the symmetric tridiagonal matrix with `diagonal`
// (n >= 1 numbers) and off-diagonal `beside` (the first n - 1 numbers, nonzero). The eigenvalue by
// Laguerre's method from above (monotonic, cubic convergence); the vector from factorisations from
// both ends, joined at their best match.
TridiagonalTop TopOfTridiagonal(std::span<const double> diagonal, std::span<const double> beside);

// A node's states: consecutive rows. Not owned.
struct NodeRows {
  const float* data = nullptr;
  int count = 0;  // at least 1
  int dimensions = 0;

  const float* row(int r) const { return data + static_cast<std::ptrdiff_t>(r) * dimensions; }
};

// Nodes of up to kTightFrames frames use kTightTolerance, larger ones kLooseTolerance.
inline constexpr int kTightFrames = 16384;
inline constexpr double kTightTolerance = 1e-6;
inline constexpr double kLooseTolerance = 1e-3;

struct NodeAxis {
  Eigen::VectorXd mean;
  PrincipalAxis principal;  // of the scatter matrix: sum of c c^T over centred states c
};

// Returns mean and principal axis. The residual |S a - v a| / v is at most kTightTolerance or
// kLooseTolerance, plus rounding (about 1e-7 times the sum of |x|^2, over v). So the scatter v
// along the axis is within that fraction of an eigenvalue of S, and the sine of the angle to the
// true axis is at most residual * v / (v - v2), with v2 the scatter along the second axis. Nodes of
// up to some thousand frames start from the dimension with the largest variance; larger ones from
// the axis of some thousand evenly spread frames, which also separates axes of similar scatter.
// `centred` is scratch memory for reuse. The result is bitwise identical for any `parallel`.
// O(frames * dimensions) for each product with S.
NodeAxis FindNodeAxis(const NodeRows& rows, std::vector<float>& centred,
                      const ParallelFor& parallel);

}  // namespace motiondb::core
