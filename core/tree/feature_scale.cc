#include "core/tree/feature_scale.h"

#include <cmath>

namespace motiondb::core {

void FeatureScale::Apply(FrameMatrix& states) const { states.array().rowwise() /= divisor.array(); }

void FeatureScale::Revert(FrameMatrix& states) const {
  states.array().rowwise() *= divisor.array();
}

FeatureScale MakeFeatureScale(Scaling scaling, const Eigen::Ref<const FrameMatrix>& states) {
  const Eigen::Index dimensions = states.cols();
  FeatureScale scale{Eigen::RowVectorXf::Ones(dimensions)};
  if (scaling == Scaling::kNone || states.rows() == 0) return scale;

  const auto count = static_cast<double>(states.rows());
  Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(dimensions);
  for (Eigen::Index f = 0; f < states.rows(); ++f) mean += states.row(f).cast<double>();
  mean /= count;
  Eigen::RowVectorXd variance = Eigen::RowVectorXd::Zero(dimensions);
  for (Eigen::Index f = 0; f < states.rows(); ++f) {
    variance += (states.row(f).cast<double>() - mean).cwiseAbs2();
  }
  variance /= count;

  const auto divisor = [](double v) { return v > 0 ? static_cast<float>(std::sqrt(v)) : 1.0f; };
  if (scaling == Scaling::kDimension) {
    scale.divisor = variance.unaryExpr(divisor);
    return scale;
  }
  double pooled[2] = {0, 0};
  const auto is_velocity = [](Eigen::Index d) { return d % 6 >= 3; };
  for (Eigen::Index d = 0; d < dimensions; ++d) pooled[is_velocity(d)] += variance[d];
  for (double& sum : pooled) sum /= static_cast<double>(dimensions) / 2;
  for (Eigen::Index d = 0; d < dimensions; ++d) scale.divisor[d] = divisor(pooled[is_velocity(d)]);
  return scale;
}

}  // namespace motiondb::core
