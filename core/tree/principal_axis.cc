#include "core/tree/principal_axis.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace motiondb::core {
namespace {

constexpr double kTolerance = 1e-9;
constexpr int kMaxSteps = 60;    // past this a full decomposition costs no more
constexpr int kCheckEvery = 10;  // steps between looks at the residual

void FixSign(Eigen::VectorXd& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
}

// Lanczos: an orthonormal basis Q of the Krylov space in which C is the tridiagonal (alpha, beta).
// Returns an empty vector where it has not converged.
Eigen::VectorXd Lanczos(const Eigen::MatrixXd& covariance, Eigen::Index start) {
  const Eigen::Index dimensions = covariance.rows();
  const auto steps = static_cast<int>(std::min<Eigen::Index>(kMaxSteps, dimensions));
  const auto symmetric = covariance.selfadjointView<Eigen::Lower>();
  Eigen::MatrixXd basis(dimensions, steps);
  Eigen::VectorXd alpha(steps);
  Eigen::VectorXd beta(steps);

  // The column of the largest variance leans towards the leading axis.
  Eigen::VectorXd q = symmetric * Eigen::VectorXd::Unit(dimensions, start);
  q.normalize();
  for (int k = 0; k < steps; ++k) {
    basis.col(k) = q;
    Eigen::VectorXd w = symmetric * q;
    alpha[k] = q.dot(w);
    for (int pass = 0; pass < 2; ++pass) {
      w -= basis.leftCols(k + 1) * (basis.leftCols(k + 1).transpose() * w);
    }
    beta[k] = w.norm();
    const bool exhausted = beta[k] <= 1e-14 * alpha.head(k + 1).cwiseAbs().maxCoeff();
    if (exhausted || (k + 1) % kCheckEvery == 0 || k + 1 == steps) {
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> small;
      small.computeFromTridiagonal(alpha.head(k + 1), beta.head(k));
      const double residual = beta[k] * std::abs(small.eigenvectors()(k, k));
      if (residual <= kTolerance * small.eigenvalues()[k]) {
        return (basis.leftCols(k + 1) * small.eigenvectors().col(k)).normalized();
      }
      if (exhausted) break;
    }
    q = w / beta[k];
  }
  return {};
}

}  // namespace

Eigen::VectorXd PrincipalAxis(const Eigen::MatrixXd& covariance) {
  Eigen::Index widest = 0;
  const double variance = covariance.diagonal().maxCoeff(&widest);
  if (!(variance > 0)) return Eigen::VectorXd::Unit(covariance.rows(), 0);
  Eigen::VectorXd axis = Lanczos(covariance, widest);
  if (axis.size() == 0) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> full(covariance);
    axis = full.eigenvectors().rightCols<1>();
  }
  FixSign(axis);
  return axis;
}

}  // namespace motiondb::core
