#include "core/tree/feature_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace motiondb::core {

void FeatureScale::Apply(FrameMatrix& states) const { states.array().rowwise() /= divisor.array(); }

void FeatureScale::Revert(FrameMatrix& states) const {
  states.array().rowwise() *= divisor.array();
}

namespace {

constexpr Eigen::Index kLookedAt = 4096;  // frames that the quantiles are of, at most
constexpr double kTail = 0.01;            // of the frames on each side, and not less than
constexpr Eigen::Index kLeastTail = 3;
constexpr float kRoom = 2;  // ranges beside the middle one

bool IsVelocity(Eigen::Index d) { return d % 6 >= 3; }

// Between which numbers each dimension's count: 1 x dimensions each.
struct Bounds {
  Eigen::RowVectorXf least;
  Eigen::RowVectorXf most;
};

Bounds FindBounds(const Eigen::Ref<const FrameMatrix>& states) {
  const Eigen::Index dimensions = states.cols();
  const Eigen::Index count = std::min(states.rows(), kLookedAt);
  const auto tail =
      std::min(count / 8,
               std::max(kLeastTail, static_cast<Eigen::Index>(kTail * static_cast<double>(count))));
  Bounds bounds{Eigen::RowVectorXf(dimensions), Eigen::RowVectorXf(dimensions)};
  std::vector<float> values(count);
  float mean_range[2] = {0, 0};
  for (Eigen::Index d = 0; d < dimensions; ++d) {
    for (Eigen::Index i = 0; i < count; ++i) values[i] = states(i * states.rows() / count, d);
    const auto low = values.begin() + tail;
    const auto high = values.end() - 1 - tail;
    std::nth_element(values.begin(), low, values.end());
    bounds.least[d] = *low;
    std::nth_element(low, high, values.end());  // moves what stands at `low`
    bounds.most[d] = *high;
    const float range = bounds.most[d] - bounds.least[d];
    mean_range[IsVelocity(d)] += 2 * range / static_cast<float>(dimensions);
  }
  for (Eigen::Index d = 0; d < dimensions; ++d) {
    const float range = std::max(bounds.most[d] - bounds.least[d], mean_range[IsVelocity(d)]);
    // Where nearly nothing varies, what varies is no outlier.
    const float room = range > 0 ? kRoom * range : std::numeric_limits<float>::infinity();
    bounds.least[d] -= room;
    bounds.most[d] += room;
  }
  return bounds;
}

}  // namespace

Eigen::RowVectorXd RobustVariances(const Eigen::Ref<const FrameMatrix>& states) {
  if (states.rows() == 0) return Eigen::RowVectorXd::Zero(states.cols());
  const Bounds bounds = FindBounds(states);
  Eigen::RowVectorXd count = Eigen::RowVectorXd::Zero(states.cols());
  Eigen::RowVectorXd mean = count;
  Eigen::RowVectorXd squares = count;
  const auto within = [&](Eigen::Index f) {
    const auto row = states.row(f).array();
    return ((row >= bounds.least.array()) && (row <= bounds.most.array())).cast<double>().eval();
  };
  for (Eigen::Index f = 0; f < states.rows(); ++f) {
    const auto counts = within(f);
    count.array() += counts;
    mean.array() += counts * states.row(f).cast<double>().array();
  }
  mean.array() /= count.array().max(1);
  for (Eigen::Index f = 0; f < states.rows(); ++f) {
    squares.array() += within(f) * (states.row(f).cast<double>() - mean).array().square();
  }
  return squares.array() / count.array().max(1);
}

FeatureScale MakeFeatureScale(Scaling scaling, const Eigen::Ref<const FrameMatrix>& states) {
  const Eigen::Index dimensions = states.cols();
  FeatureScale scale{Eigen::RowVectorXf::Ones(dimensions)};
  if (scaling == Scaling::kNone || states.rows() == 0) return scale;

  const Eigen::RowVectorXd variance = RobustVariances(states);
  const auto divisor = [](double v) { return v > 0 ? static_cast<float>(std::sqrt(v)) : 1.0f; };
  if (scaling == Scaling::kDimension) {
    scale.divisor = variance.unaryExpr(divisor);
    return scale;
  }
  double pooled[2] = {0, 0};
  for (Eigen::Index d = 0; d < dimensions; ++d) pooled[IsVelocity(d)] += variance[d];
  for (double& sum : pooled) sum /= static_cast<double>(dimensions) / 2;
  for (Eigen::Index d = 0; d < dimensions; ++d) scale.divisor[d] = divisor(pooled[IsVelocity(d)]);
  return scale;
}

}  // namespace motiondb::core
