#include "core/tree/node_gaussians.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr double kShrinkFrames = 16;     // a node of this many frames is half shrunk
constexpr double kTowards = 0.3;         // of the database's variance
constexpr double kRelativeFloor = 1e-3;  // of the mean variance

struct MeanVariance {
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd variance;
};

MeanVariance Moments(const Branch& branch, const Tree& tree, const FrameMatrix& states) {
  const auto count = static_cast<double>(branch.end - branch.begin);
  MeanVariance moments{Eigen::RowVectorXd::Zero(states.cols()),
                       Eigen::RowVectorXd::Zero(states.cols())};
  for (std::int32_t i = branch.begin; i < branch.end; ++i) {
    moments.mean += states.row(tree.frame_order()[i]).cast<double>();
  }
  moments.mean /= count;
  for (std::int32_t i = branch.begin; i < branch.end; ++i) {
    moments.variance +=
        (states.row(tree.frame_order()[i]).cast<double>() - moments.mean).cwiseAbs2();
  }
  moments.variance /= count;
  return moments;
}

}  // namespace

absl::StatusOr<NodeGaussians> NodeGaussians::Create(FrameMatrix means, FrameMatrix variances) {
  if (means.rows() != variances.rows() || means.cols() != variances.cols() || !means.allFinite() ||
      !variances.allFinite() || !(variances.array() > 0).all()) {
    return DataLoss("node statistics: means and variances must be finite, variances positive");
  }
  NodeGaussians gaussians;
  gaussians.inverse_deviations_ = variances.array().rsqrt();
  gaussians.log_normalizers_ =
      -0.5 * (variances.cast<double>() * 2 * std::numbers::pi).array().log().rowwise().sum();
  gaussians.means_ = std::move(means);
  gaussians.variances_ = std::move(variances);
  return gaussians;
}

NodeGaussians NodeGaussians::Fit(const Tree& tree, const FrameMatrix& states,
                                 const ParallelFor& parallel) {
  const auto& branches = tree.branches();
  FrameMatrix means(branches.size(), states.cols());
  FrameMatrix variances(branches.size(), states.cols());
  const Eigen::RowVectorXd all = Moments(branches[0], tree, states).variance;
  // Where nothing varies at all, any positive number serves.
  const double floor = all.mean() > 0 ? kRelativeFloor * all.mean() : 1.0;
  parallel(static_cast<int>(branches.size()), [&](int b) {
    const MeanVariance node = Moments(branches[b], tree, states);
    const double shrink = kShrinkFrames / (branches[b].end - branches[b].begin + kShrinkFrames);
    means.row(b) = node.mean.cast<float>();
    variances.row(b) =
        ((1 - shrink) * node.variance + shrink * kTowards * all).cwiseMax(floor).cast<float>();
  });
  return *Create(std::move(means), std::move(variances));
}

double NodeGaussians::LogDensity(int branch, const float* x) const {
  using Row = Eigen::Map<const Eigen::Array<float, 1, Eigen::Dynamic>>;
  const Eigen::Index n = means_.cols();
  const float squares = ((Row(x, n) - Row(means_.row(branch).data(), n)) *
                         Row(inverse_deviations_.row(branch).data(), n))
                            .square()
                            .sum();
  if (!std::isnan(squares)) return log_normalizers_[branch] - 0.5 * squares;

  double log_density = 0;
  for (Eigen::Index d = 0; d < n; ++d) {
    if (std::isnan(x[d])) continue;
    const double z = (x[d] - means_(branch, d)) * inverse_deviations_(branch, d);
    log_density -= 0.5 * (z * z + std::log(2 * std::numbers::pi * variances_(branch, d)));
  }
  return log_density;
}

}  // namespace motiondb::core
