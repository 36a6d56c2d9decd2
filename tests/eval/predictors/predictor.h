// What the protocols of prediction ask: a way to say where markers will be, the database's or a
// peer's.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

struct Forecast {
  core::FrameMatrix positions_m;   // horizons x 3 N_v, in the world of the past
  std::vector<double> confidence;  // one a horizon, 0 to 1; empty if the method gives none
};

class Predictor {
 public:
  virtual ~Predictor() = default;

  // Learns the clips, with parameters chosen for these horizons (s) from these clips alone. Once.
  virtual absl::Status Fit(const ClipSet& training, const std::vector<double>& horizons) = 0;

  // From the last frame of the past, at least two frames. Safe to call from any thread once fitted.
  virtual absl::StatusOr<Forecast> Predict(const core::MarkerMotion& past,
                                           const std::vector<double>& horizons) const = 0;

  // How the parameters were chosen, and which they are. Once fitted.
  virtual std::string chosen() const = 0;
  virtual double model_bytes() const = 0;
};

struct PredictionMethod {
  std::string name;
  std::function<std::unique_ptr<Predictor>()> make;
};

}  // namespace motiondb::tests
