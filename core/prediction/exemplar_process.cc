#include "core/prediction/exemplar_process.h"

#include <Eigen/Cholesky>

namespace motiondb::core {

ExemplarWeights WeighExemplars(const FrameMatrix& keys, const Eigen::RowVectorXf& query,
                               double kernel_length, double noise) {
  const Eigen::VectorXd squares = keys.rowwise().squaredNorm().cast<double>();
  const Eigen::MatrixXd dots = (keys * keys.transpose()).cast<double>();
  const Eigen::Index count = keys.rows();
  Eigen::MatrixXd kernel(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double apart = std::sqrt(std::max(0.0, squares[i] + squares[j] - 2 * dots(i, j)));
      kernel(i, j) = std::exp(-apart / kernel_length);
    }
    kernel(i, i) = 1 + noise;
  }
  const Eigen::VectorXd to_query =
      ((keys.rowwise() - query).rowwise().norm().cast<double>().array() / -kernel_length).exp();
  ExemplarWeights weighed;
  weighed.weights = kernel.selfadjointView<Eigen::Lower>().llt().solve(to_query);
  weighed.variance = 1 - to_query.dot(weighed.weights);
  return weighed;
}

}  // namespace motiondb::core
