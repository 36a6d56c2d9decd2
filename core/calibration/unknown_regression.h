// Logistic regression that separates unknown from known held-out motion, for any features.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace motiondb::core {

// A held-out observation of a clip: unknown if the clip's label was held out, too.
struct HeldOutKind {
  bool is_unknown = false;
  int clip = 0;
  std::size_t label = 0;
};

// P(unknown) = 1 / (1 + exp(-(intercept + weights x))).
struct UnknownRegression {
  double intercept = 0;
  Eigen::VectorXd weights;
};

// Fits the regression to `features` (samples x features, finite), a row for each of `kinds`.
// nullopt unless there are at least 4 known and 4 unknown clips, each of at least two labels.
//
// Labels count equally; unknown samples have the share kUnknownShare of all weight. The ridge is
// 0.1 over the number of clips, on standardized features. `signs`: the sign that a feature's weight
// has by its meaning, 1 or -1; 0 leaves the feature out. A weight with another sign is 0. Newton's
// method; O(samples * features^2) for each step.
std::optional<UnknownRegression> FitUnknownRegression(const std::vector<HeldOutKind>& kinds,
                                                      const Eigen::MatrixXd& features,
                                                      std::vector<int> signs);

}  // namespace motiondb::core
