// What some numbers are where others are known, from examples of both: ridge regression, which is
// the conditional mean of a Gaussian fitted to the examples. Pure; safe to call from any thread.
#pragma once

#include <Eigen/Core>

namespace motiondb::core {

struct Regressed {
  Eigen::VectorXd mean;      // wanted numbers
  Eigen::VectorXd variance;  // of each about its mean, as far as the examples can tell
};

// `known` (examples x p) and `wanted` (examples x q) with weights (examples, above 0, sum 1); `at`
// is what is known now (p). `noise_variance` is that of each known number. The variance grows with
// how little the examples settle and with how far `at` lies from them. At least one example.
// O(examples^2 (p + q + examples)): for tens of examples.
Regressed Regress(const Eigen::MatrixXd& known, const Eigen::MatrixXd& wanted,
                  const Eigen::VectorXd& weights, const Eigen::VectorXd& at, double noise_variance);

}  // namespace motiondb::core
