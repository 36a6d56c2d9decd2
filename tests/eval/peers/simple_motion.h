// Peers of prediction that learn nothing: constant pose, or constant velocity of every marker.
#pragma once

#include "tests/eval/predictors/predictor.h"

namespace motiondb::tests {

class SimpleMotion : public Predictor {
 public:
  // `share_of_velocity`: fraction of the last frame's velocity (a backward difference) that is
  // kept, 0 or 1.
  explicit SimpleMotion(float share_of_velocity) : share_of_velocity_(share_of_velocity) {}

  absl::Status Fit(const ClipSet&, const std::vector<double>&) override { return absl::OkStatus(); }
  absl::StatusOr<Forecast> Predict(const core::MarkerMotion& past,
                                   const std::vector<double>& horizons) const override;
  std::string chosen() const override { return "no parameters"; }
  double model_bytes() const override { return 0; }

 private:
  const float share_of_velocity_;
};

}  // namespace motiondb::tests
