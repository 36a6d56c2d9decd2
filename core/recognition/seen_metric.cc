#include "core/recognition/seen_metric.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace motiondb::core {

MotionMetric MetricOfSeen(const MotionMetric& metric, const std::vector<Eigen::Index>& seen) {
  const Eigen::Index dimensions = metric.mean.size();
  std::vector<Eigen::Index> unseen;
  for (Eigen::Index d = 0; d < dimensions; ++d) {
    if (!std::binary_search(seen.begin(), seen.end(), d)) unseen.push_back(d);
  }
  // The inverse of a block of S by the inverse of all of it, which is what whitening holds.
  const Eigen::MatrixXd inverse = (metric.whitening * metric.whitening.transpose()).cast<double>();
  Eigen::MatrixXd of_seen = inverse(seen, seen);
  if (!unseen.empty()) {
    const Eigen::MatrixXd between = inverse(unseen, seen);
    of_seen -=
        between.transpose() * Eigen::LLT<Eigen::MatrixXd>(inverse(unseen, unseen)).solve(between);
  }
  const Eigen::MatrixXd whitening = Eigen::LLT<Eigen::MatrixXd>(of_seen).matrixL();
  const Eigen::MatrixXd whitened =
      whitening.transpose() * metric.loadings(seen, Eigen::all).cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spread(whitened.transpose() * whitened);
  // Directions along which stored motion does not vary tell nothing apart.
  const Eigen::Index directions =
      std::max<Eigen::Index>(1, (spread.eigenvalues().array() > 1e-9).count());
  const Eigen::MatrixXd projection =
      whitening * whitened * spread.eigenvectors().rightCols(directions) *
      spread.eigenvalues().tail(directions).cwiseSqrt().cwiseInverse().asDiagonal();

  MotionMetric own{metric.mean, metric.loadings, metric.noise};
  own.whitening.setZero(dimensions, whitening.cols());
  own.projection.setZero(dimensions, directions);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    own.whitening.row(seen[i]) = whitening.row(static_cast<Eigen::Index>(i)).cast<float>();
    own.projection.row(seen[i]) = projection.row(static_cast<Eigen::Index>(i)).cast<float>();
  }
  return own;
}

}  // namespace motiondb::core
