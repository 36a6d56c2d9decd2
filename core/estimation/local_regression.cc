#include "core/estimation/local_regression.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace motiondb::core {

Regressed Regress(const Eigen::MatrixXd& known, const Eigen::MatrixXd& wanted,
                  const Eigen::VectorXd& weights, const Eigen::VectorXd& at,
                  double noise_variance) {
  const Eigen::VectorXd root = weights.cwiseSqrt();
  const Eigen::RowVectorXd known_mean = weights.transpose() * known;
  const Eigen::RowVectorXd wanted_mean = weights.transpose() * wanted;
  const Eigen::MatrixXd x = root.asDiagonal() * (known.rowwise() - known_mean);
  const Eigen::MatrixXd y = root.asDiagonal() * (wanted.rowwise() - wanted_mean);

  // The dual form: there are fewer examples than numbers.
  const Eigen::MatrixXd shared = x * x.transpose();
  Eigen::MatrixXd kernel = shared;
  kernel.diagonal().array() += noise_variance;
  const Eigen::LLT<Eigen::MatrixXd> solver(kernel);
  const Eigen::VectorXd beside = x * (at - known_mean.transpose());
  const Eigen::VectorXd share = solver.solve(beside);
  const Eigen::MatrixXd solved = solver.solve(y);

  Regressed regressed;
  regressed.mean = wanted_mean.transpose() + y.transpose() * share;
  // What the examples leave open, made up for what fitting them has used, and for the leverage.
  const double examples = 1 / weights.squaredNorm();
  const double used = std::min(solver.solve(shared).trace() + 1, 0.9 * examples);
  const double leverage = 1 / examples + share.cwiseAbs2().dot(weights);
  regressed.variance = (1 + leverage) * examples / (examples - used) * noise_variance *
                       y.cwiseProduct(solved).colwise().sum().transpose();
  return regressed;
}

}  // namespace motiondb::core
