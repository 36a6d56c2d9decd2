#include "core/tree/node_gaussians.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "core/tree/feature_scale.h"
#include "core/tree/row_kernels.h"

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

Moments MomentsOf(std::span<const std::int32_t> frames,
                  const Eigen::Ref<const FrameMatrix>& states) {
  Moments moments{static_cast<double>(frames.size()), Eigen::RowVectorXd::Zero(states.cols()),
                  Eigen::RowVectorXd::Zero(states.cols())};
  for (const std::int32_t f : frames) moments.mean += states.row(f).cast<double>();
  moments.mean /= moments.count;
  for (const std::int32_t f : frames) {
    moments.squares += (states.row(f).cast<double>() - moments.mean).cwiseAbs2();
  }
  return moments;
}

std::span<const std::int32_t> FramesOf(const Tree& tree, const Branch& branch) {
  return std::span(tree.frame_order()).subspan(branch.begin, branch.end - branch.begin);
}

// Of two groups together, from those of each.
Moments Together(const Moments& a, const Moments& b) {
  const double count = a.count + b.count;
  const Eigen::RowVectorXd apart = b.mean - a.mean;
  return {count, a.mean + (b.count / count) * apart,
          a.squares + b.squares + (a.count * b.count / count) * apart.cwiseAbs2()};
}

// Of every branch: leaves from their frames, the others from their children.
std::vector<Moments> MomentsOfBranches(const Tree& tree,
                                       const Eigen::Ref<const FrameMatrix>& states,
                                       const ParallelFor& parallel) {
  const auto& branches = tree.branches();
  std::vector<Moments> moments(branches.size());
  parallel(static_cast<int>(branches.size()), [&](int b) {
    if (branches[b].left < 0) moments[b] = MomentsOf(FramesOf(tree, branches[b]), states);
  });
  for (auto b = static_cast<int>(branches.size()) - 1; b >= 0; --b) {  // children follow parents
    if (branches[b].left < 0) continue;
    moments[b] = Together(moments[branches[b].left], moments[branches[b].right]);
  }
  return moments;
}

// Of the frames from `first_added` on in each branch; with count 0 where there are none.
std::vector<Moments> MomentsOfAdded(const Tree& tree, int first_added,
                                    const Eigen::Ref<const FrameMatrix>& states) {
  const auto& branches = tree.branches();
  std::vector<Moments> added(branches.size());
  for (auto b = static_cast<int>(branches.size()) - 1; b >= 0; --b) {  // children follow parents
    const Branch& branch = branches[b];
    if (branch.left >= 0) {
      const Moments& left = added[branch.left];
      const Moments& right = added[branch.right];
      added[b] = left.count == 0 ? right : right.count == 0 ? left : Together(left, right);
      continue;
    }
    const auto frames = FramesOf(tree, branch);  // ascending
    const auto more = std::ranges::lower_bound(frames, first_added) - frames.begin();
    if (more < std::ssize(frames)) added[b] = MomentsOf(frames.subspan(more), states);
  }
  return added;
}

double Shrink(double count) { return kShrinkFrames / (count + kShrinkFrames); }

// How a branch's variances are made from its moments and the whole database's variances.
class Shrinking {
 public:
  explicit Shrinking(Eigen::RowVectorXd all)
      : all_(std::move(all)),
        // Where nothing varies at all, any positive number serves.
        floor_(all_.mean() > 0 ? kRelativeFloor * all_.mean() : 1.0) {}
  // From the root's own variances: all = (1 - l) all + l * 0.3 * all, turned round.
  static Shrinking OfRoot(const Eigen::RowVectorXf& variances, double count) {
    const double shrink = Shrink(count);
    return Shrinking(variances.cast<double>() / (1 - shrink + shrink * kTowards));
  }

  Eigen::RowVectorXf Variances(const Moments& node) const {
    const double shrink = Shrink(node.count);
    return ((1 - shrink) / node.count * node.squares + shrink * kTowards * all_)
        .cwiseMax(floor_)
        .cast<float>();
  }
  // The sum of squares that gave these variances.
  Eigen::RowVectorXd Squares(const Eigen::RowVectorXf& variances, double count) const {
    const double shrink = Shrink(count);
    return (variances.cast<double>() - shrink * kTowards * all_).cwiseMax(0) * count / (1 - shrink);
  }

 private:
  Eigen::RowVectorXd all_;
  double floor_;
};

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

NodeGaussians NodeGaussians::Fit(const Tree& tree, const Eigen::Ref<const FrameMatrix>& states,
                                 const ParallelFor& parallel) {
  const auto& branches = tree.branches();
  FrameMatrix means(branches.size(), states.cols());
  FrameMatrix variances(branches.size(), states.cols());
  std::vector<Moments> moments = MomentsOfBranches(tree, states, parallel);
  // What all nodes are shrunk towards: not to be spoiled by a few corrupt frames.
  moments[0].squares =
      moments[0].squares.cwiseMin(moments[0].count * RobustVariances(states, parallel));
  const Shrinking shrinking(moments[0].squares / moments[0].count);
  parallel(static_cast<int>(branches.size()), [&](int b) {
    means.row(b) = moments[b].mean.cast<float>();
    variances.row(b) = shrinking.Variances(moments[b]);
  });
  return *Create(std::move(means), std::move(variances));
}

NodeGaussians NodeGaussians::Grown(const Tree& tree, int first_added,
                                   const Eigen::Ref<const FrameMatrix>& states,
                                   const ParallelFor& parallel) const {
  const auto& branches = tree.branches();
  const std::vector<Moments> added = MomentsOfAdded(tree, first_added, states);
  const Shrinking before = Shrinking::OfRoot(variances_.row(0), first_added);
  const auto moments_of = [&](int b) -> Moments {
    const double known = branches[b].end - branches[b].begin - added[b].count;
    if (added[b].count > 0 && branches[b].left < 0) {
      return MomentsOf(FramesOf(tree, branches[b]), states);
    }
    const Moments had{known, means_.row(b).cast<double>(),
                      before.Squares(variances_.row(b), known)};
    return added[b].count > 0 ? Together(had, added[b]) : had;
  };
  const Moments root = moments_of(0);
  const Shrinking after(root.squares / root.count);
  FrameMatrix means(means_.rows(), means_.cols());
  FrameMatrix variances(means_.rows(), means_.cols());
  parallel(static_cast<int>(branches.size()), [&](int b) {
    const Moments moments = moments_of(b);
    means.row(b) = moments.mean.cast<float>();
    variances.row(b) = after.Variances(moments);
  });
  return *Create(std::move(means), std::move(variances));
}

double NodeGaussians::LogDensity(int branch, const float* x) const {
  const Eigen::Index n = means_.cols();
  const float squares = ScaledSquares(x, means_.row(branch).data(),
                                      inverse_deviations_.row(branch).data(), static_cast<int>(n));
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

bool NodeGaussians::IsBoxBelow(int branch, const float* low, const float* high,
                               float log_density) const {
  return IsBoxBeyond(low, high, means_.row(branch).data(), inverse_deviations_.row(branch).data(),
                     dimension_count(),
                     2 * (static_cast<float>(log_normalizers_[branch]) - log_density));
}

bool NodeGaussians::LogDensitiesFrom(int branch, const float* frames, int blocks,
                                     const float* at_least, std::vector<float>& scratch,
                                     float* log_densities) const {
  const int count = blocks * kSquaresLanes;
  const auto normalizer = static_cast<float>(log_normalizers_[branch]);
  scratch.resize(count);
  for (int f = 0; f < count; ++f) scratch[f] = 2 * (normalizer - at_least[f]);
  if (ScaledSquaresWithin(frames, blocks, means_.row(branch).data(),
                          inverse_deviations_.row(branch).data(), dimension_count(), scratch.data(),
                          log_densities) == 0) {
    return false;
  }
  for (int f = 0; f < count; ++f) log_densities[f] = normalizer - 0.5F * log_densities[f];
  return true;
}

}  // namespace motiondb::core
