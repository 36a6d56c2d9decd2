#include "core/tree/principal_axis.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/tree/tridiagonal.h"

namespace motiondb::core {
namespace {

constexpr Eigen::Index kBasisGrowth = 16;
// Below this part of the largest eigenvalue a new direction is rounding: the space is exhausted.
constexpr double kExhausted = 1e-14;
// A direction that loses more than this to the basis is made orthogonal to it a second time.
constexpr double kSecondPass = 0.1;

void FixSign(Eigen::VectorXd& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
}

}  // namespace

PrincipalAxis FindPrincipalAxis(const SymmetricProduct& product, const Eigen::VectorXd& start,
                                double tolerance) {
  const Eigen::Index dimensions = start.size();
  // An orthonormal basis of the Krylov space, in which C is the tridiagonal (alpha, beta).
  Eigen::MatrixXd basis(dimensions, std::min(kBasisGrowth, dimensions));
  std::vector<double> alpha;
  std::vector<double> beta;
  PrincipalAxis found;
  Eigen::VectorXd q = start.normalized();
  Eigen::VectorXd w(dimensions);
  Eigen::VectorXd overlap;
  for (Eigen::Index k = 0;; ++k) {
    if (k == basis.cols()) {
      basis.conservativeResize(Eigen::NoChange, std::min(2 * basis.cols(), dimensions));
    }
    basis.col(k) = q;
    product(q, w);
    alpha.push_back(q.dot(w));
    double length = w.norm();
    const auto so_far = basis.leftCols(k + 1);
    for (int pass = 0; pass < 2; ++pass) {
      overlap.noalias() = so_far.transpose() * w;
      w.noalias() -= so_far * overlap;
      const double before = std::exchange(length, w.norm());
      if (length > kSecondPass * before) break;
    }
    beta.push_back(length);

    const TridiagonalTop top = TopOfTridiagonal(alpha, beta);
    found.variance = top.value;
    found.residual = top.value > 0 ? length * std::abs(top.vector[k]) / top.value : 0;
    const bool exhausted = length <= kExhausted * top.value || k + 1 == dimensions;
    if (exhausted || found.residual <= tolerance) {
      found.products = static_cast<int>(k) + 1;
      found.axis = (so_far * top.vector).normalized();
      FixSign(found.axis);
      return found;
    }
    q = w / length;
  }
}

}  // namespace motiondb::core
