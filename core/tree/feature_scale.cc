#include "core/tree/feature_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/tree/row_kernels.h"

namespace motiondb::core {

void FeatureScale::Apply(FrameMatrix& states) const { states.array().rowwise() /= divisor.array(); }

void FeatureScale::Revert(FrameMatrix& states) const {
  states.array().rowwise() *= divisor.array();
}

namespace {

constexpr Eigen::Index kLookedAt = 4096;  // frames that the quantiles are of, at most
constexpr double kTail = 0.01;            // of the frames on each side, and not less than
constexpr Eigen::Index kLeastTail = 3;
constexpr Eigen::Index kDimensionsTogether = 16;  // a cache line of a row
constexpr int kParts = 16;                        // of the sums, whatever the threads
constexpr float kRoom = 2;                        // ranges beside the middle one

bool IsVelocity(Eigen::Index d) { return d % 6 >= 3; }

// Between which numbers each dimension's count: 1 x dimensions each.
struct Bounds {
  Eigen::RowVectorXf least;
  Eigen::RowVectorXf most;
};

Bounds FindBounds(const Eigen::Ref<const FrameMatrix>& states, const ParallelFor& parallel) {
  const Eigen::Index dimensions = states.cols();
  const Eigen::Index count = std::min(states.rows(), kLookedAt);
  const auto tail =
      std::min(count / 8,
               std::max(kLeastTail, static_cast<Eigen::Index>(kTail * static_cast<double>(count))));
  Bounds bounds{Eigen::RowVectorXf(dimensions), Eigen::RowVectorXf(dimensions)};
  parallel(static_cast<int>((dimensions + kDimensionsTogether - 1) / kDimensionsTogether),
           [&](int group) {
             const Eigen::Index first = group * kDimensionsTogether;
             const Eigen::Index together = std::min(kDimensionsTogether, dimensions - first);
             Eigen::MatrixXf values(count, together);  // one dimension after the other
             for (Eigen::Index i = 0; i < count; ++i) {
               values.row(i) = states.row(i * states.rows() / count).segment(first, together);
             }
             for (Eigen::Index d = 0; d < together; ++d) {
               float* const begin = values.col(d).data();
               float* const low = begin + tail;
               float* const high = begin + count - 1 - tail;
               std::nth_element(begin, low, begin + count);
               bounds.least[first + d] = *low;
               std::nth_element(low, high, begin + count);  // moves what stands at `low`
               bounds.most[first + d] = *high;
             }
           });
  float mean_range[2] = {0, 0};
  for (Eigen::Index d = 0; d < dimensions; ++d) {
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

// About the middle of the bounds, or zero where there are none: near enough to the mean that the
// squares lose nothing.
Eigen::RowVectorXd CentreOf(const Bounds& bounds) {
  const Eigen::RowVectorXd middle = (bounds.least.cast<double>() + bounds.most.cast<double>()) / 2;
  return middle.array().isFinite().select(middle, 0.0);
}

}  // namespace

Eigen::RowVectorXd RobustVariances(const Eigen::Ref<const FrameMatrix>& states,
                                   const ParallelFor& parallel) {
  const Eigen::Index dimensions = states.cols();
  if (states.rows() == 0) return Eigen::RowVectorXd::Zero(dimensions);
  const Bounds bounds = FindBounds(states, parallel);
  const Eigen::RowVectorXd centre = CentreOf(bounds);
  // Of each part: how many count, the sum of (x - centre), and that of its square.
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> parts(kParts);
  parallel(kParts, [&](int part) {
    const Eigen::Index begin = part * states.rows() / kParts;
    const Eigen::Index end = (part + 1) * states.rows() / kParts;
    auto& sums = parts[part];
    sums.setZero(3, dimensions);
    AddWithin(states.data() + begin * states.outerStride(), static_cast<int>(end - begin),
              states.outerStride(), static_cast<int>(dimensions), bounds.least.data(),
              bounds.most.data(), centre.data(), sums.row(0).data(), sums.row(1).data(),
              sums.row(2).data());
  });
  for (int part = 1; part < kParts; ++part) parts[0] += parts[part];
  const auto count = parts[0].row(0).array().max(1);
  const auto mean = parts[0].row(1).array() / count;
  return (parts[0].row(2).array() / count - mean.square()).max(0);
}

FeatureScale MakeFeatureScale(Scaling scaling, const Eigen::Ref<const FrameMatrix>& states,
                              const ParallelFor& parallel) {
  const Eigen::Index dimensions = states.cols();
  FeatureScale scale{Eigen::RowVectorXf::Ones(dimensions)};
  if (scaling == Scaling::kNone || states.rows() == 0) return scale;

  const Eigen::RowVectorXd variance = RobustVariances(states, parallel);
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
