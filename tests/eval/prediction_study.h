// The experiments of prediction: every window of every held-out clip, predicted by every method.
// Run once and shared by several protocols.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/eval/predictors/predictor.h"
#include "tests/eval/progress.h"
#include "tests/eval/recognizers/cross_validation.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

inline constexpr int kFramesIn = 10;
inline constexpr int kFramesOut = 25;
// The benchmark's horizons; whole frames at its 25 Hz.
inline constexpr std::array<double, 6> kHorizonSeconds = {0.08, 0.16, 0.32, 0.4, 0.56, 1.0};
// A forecast is correct if its mean marker error is at most this. The database's confidence is the
// probability of that.
inline constexpr double kCorrectMm = 50;

// The errors of one window's forecast at each horizon.
struct ScoredForecast {
  const EvalClip* clip = nullptr;
  std::array<double, kHorizonSeconds.size()> error_mm;    // mean over the markers
  std::array<double, kHorizonSeconds.size()> confidence;  // NaN if the method has none
};

struct MethodForecasts {
  std::string name;
  std::string chosen;
  double model_bytes = 0;                 // mean over the folds
  double seconds = 0;                     // processor time of all queries
  std::vector<ScoredForecast> forecasts;  // in order of clip and window

  bool has_confidence() const {
    return !forecasts.empty() && !std::isnan(forecasts.front().confidence.front());
  }
};

// Not thread-safe; uses the given threads.
class PredictionStudy {
 public:
  // `window_step`: frames between successive windows.
  PredictionStudy(std::filesystem::path data, int window_step, core::ParallelFor parallel,
                  Progress& progress);

  // Reads the corpus on first use.
  absl::StatusOr<const Corpus*> LoadedCorpus();
  int window_step() const { return window_step_; }

  // Holds out each clip of the training half in turn. Returns one MethodForecasts per method.
  absl::StatusOr<const std::vector<MethodForecasts>*> LeaveOneOut();
  // Trains on the training half and predicts the test half. Empty if there is no test half.
  absl::StatusOr<const std::vector<MethodForecasts>*> TrainToTest();

 private:
  absl::StatusOr<std::vector<MethodForecasts>> Run(const std::string& stage,
                                                   const std::vector<Fold>& folds);

  const std::filesystem::path data_;
  const int window_step_;
  const core::ParallelFor parallel_;
  Progress& progress_;
  std::optional<Corpus> corpus_;
  std::optional<std::vector<MethodForecasts>> leave_one_out_;
  std::optional<std::vector<MethodForecasts>> train_to_test_;
};

}  // namespace motiondb::tests
