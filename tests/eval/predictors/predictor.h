// Interface of prediction methods for the protocols: the database's and the peers'.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

struct Forecast {
  core::FrameMatrix positions_m;   // horizons x 3 N_v, in the world frame of the past
  std::vector<double> confidence;  // one per horizon, 0 to 1; empty if the method has none
};

class Predictor {
 public:
  virtual ~Predictor() = default;

  // Learns the clips; chooses parameters for these horizons (s) on these clips alone. Called once.
  virtual absl::Status Fit(const ClipSet& training, const std::vector<double>& horizons) = 0;

  // Predicts from the last frame of the past, which has at least two frames. Thread-safe after Fit.
  virtual absl::StatusOr<Forecast> Predict(const core::MarkerMotion& past,
                                           const std::vector<double>& horizons) const = 0;

  // Returns how the parameters were chosen, and their values. Call after Fit.
  virtual std::string chosen() const = 0;
  virtual double model_bytes() const = 0;
};

struct PredictionMethod {
  std::string name;
  std::function<std::unique_ptr<Predictor>()> make;
};

}  // namespace motiondb::tests
