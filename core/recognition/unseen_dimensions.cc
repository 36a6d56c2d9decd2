#include "core/recognition/unseen_dimensions.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

namespace motiondb::core {

void FillUnseen(const MotionMetric& metric, Eigen::Ref<Eigen::RowVectorXf> state) {
  std::vector<Eigen::Index> seen;
  std::vector<Eigen::Index> unseen;
  for (Eigen::Index d = 0; d < state.size(); ++d) {
    (std::isnan(state[d]) ? unseen : seen).push_back(d);
  }
  if (unseen.empty()) return;
  const Eigen::MatrixXd loadings = metric.loadings(seen, Eigen::all).cast<double>();
  const Eigen::VectorXd apart = (state(seen) - metric.mean(seen)).transpose().cast<double>();
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(loadings.cols(), loadings.cols());
  if (!seen.empty()) precision.selfadjointView<Eigen::Lower>().rankUpdate(loadings.transpose());
  precision.diagonal().array() += metric.noise;
  const Eigen::VectorXd hidden = precision.selfadjointView<Eigen::Lower>().llt().solve(
      Eigen::VectorXd(loadings.transpose() * apart));
  for (const Eigen::Index d : unseen) {
    state[d] = metric.mean[d] + static_cast<float>(metric.loadings.row(d).cast<double>() * hidden);
  }
}

}  // namespace motiondb::core
