#include "core/tree/node_gaussians.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr double kShrinkFrames = 16;     // a node of this many frames is half shrunk
constexpr double kTowards = 0.3;         // of the database's variance
constexpr double kRelativeFloor = 1e-3;  // of the mean variance

// Of the frames of a branch: in all `count`, their mean, and the sum of squared differences from
// it.
struct Moments {
  double count = 0;
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd squares;
};

Moments MomentsOfLeaf(const Branch& leaf, const Tree& tree, const FrameMatrix& states) {
  Moments moments{static_cast<double>(leaf.end - leaf.begin),
                  Eigen::RowVectorXd::Zero(states.cols()), Eigen::RowVectorXd::Zero(states.cols())};
  for (std::int32_t i = leaf.begin; i < leaf.end; ++i) {
    moments.mean += states.row(tree.frame_order()[i]).cast<double>();
  }
  moments.mean /= moments.count;
  for (std::int32_t i = leaf.begin; i < leaf.end; ++i) {
    moments.squares +=
        (states.row(tree.frame_order()[i]).cast<double>() - moments.mean).cwiseAbs2();
  }
  return moments;
}

// Of two groups together, from those of each.
Moments Together(const Moments& a, const Moments& b) {
  const double count = a.count + b.count;
  const Eigen::RowVectorXd apart = b.mean - a.mean;
  return {count, a.mean + (b.count / count) * apart,
          a.squares + b.squares + (a.count * b.count / count) * apart.cwiseAbs2()};
}

// Of every branch: leaves from their frames, the others from their children.
std::vector<Moments> MomentsOfBranches(const Tree& tree, const FrameMatrix& states,
                                       const ParallelFor& parallel) {
  const auto& branches = tree.branches();
  std::vector<Moments> moments(branches.size());
  parallel(static_cast<int>(branches.size()), [&](int b) {
    if (branches[b].left < 0) moments[b] = MomentsOfLeaf(branches[b], tree, states);
  });
  for (auto b = static_cast<int>(branches.size()) - 1; b >= 0; --b) {  // children follow parents
    if (branches[b].left < 0) continue;
    moments[b] = Together(moments[branches[b].left], moments[branches[b].right]);
  }
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
  const std::vector<Moments> moments = MomentsOfBranches(tree, states, parallel);
  const Eigen::RowVectorXd all = moments[0].squares / moments[0].count;
  // Where nothing varies at all, any positive number serves.
  const double floor = all.mean() > 0 ? kRelativeFloor * all.mean() : 1.0;
  parallel(static_cast<int>(branches.size()), [&](int b) {
    const Moments& node = moments[b];
    const double shrink = kShrinkFrames / (node.count + kShrinkFrames);
    means.row(b) = node.mean.cast<float>();
    variances.row(b) = ((1 - shrink) / node.count * node.squares + shrink * kTowards * all)
                           .cwiseMax(floor)
                           .cast<float>();
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

  // One logarithm for the variances of a few dimensions at a time: their product is far from the
  // ends of a double, each being of a float's range.
  constexpr Eigen::Index kAtOnce = 7;
  double log_density = 0;
  for (Eigen::Index first = 0; first < n; first += kAtOnce) {
    double product = 1;
    for (Eigen::Index d = first; d < std::min(n, first + kAtOnce); ++d) {
      if (std::isnan(x[d])) continue;
      const double z = (x[d] - means_(branch, d)) * inverse_deviations_(branch, d);
      log_density -= 0.5 * z * z;
      product *= 2 * std::numbers::pi * variances_(branch, d);
    }
    log_density -= 0.5 * std::log(product);
  }
  return log_density;
}

}  // namespace motiondb::core
