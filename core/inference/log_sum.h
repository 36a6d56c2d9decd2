// Sums of probabilities that are kept as logarithms. Pure.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace motiondb::core {

// log of the sum of exp(logs), which are not empty; -infinity where all are.
template <typename Derived>
double LogSum(const Eigen::DenseBase<Derived>& logs) {
  const double peak = logs.maxCoeff();
  if (!std::isfinite(peak)) return peak;
  return peak + std::log((logs.derived().array() - peak).exp().sum());
}

inline double LogSum(const std::vector<double>& logs) {
  return LogSum(
      Eigen::Map<const Eigen::ArrayXd>(logs.data(), static_cast<Eigen::Index>(logs.size())));
}

}  // namespace motiondb::core
