// The experiments of prediction: every window of every clip held out in turn, forecast by every
// method. Run once, asked by several protocols.
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
// A forecast is right if its markers are on average this near to what came to be: that is what the
// database's confidence is the probability of.
inline constexpr double kRightMm = 50;

// One window's forecast against what came to be, at each horizon.
struct ScoredForecast {
  const EvalClip* clip = nullptr;
  std::array<double, kHorizonSeconds.size()> error_mm;    // mean over the markers
  std::array<double, kHorizonSeconds.size()> confidence;  // NaN where the method gives none
};

struct MethodForecasts {
  std::string name;
  std::string chosen;
  double model_bytes = 0;                 // mean over the folds
  double seconds = 0;                     // of one processor, all queries together
  std::vector<ScoredForecast> forecasts;  // in order of clip and window

  bool has_confidence() const {
    return !forecasts.empty() && !std::isnan(forecasts.front().confidence.front());
  }
};

// Not thread-safe; uses the threads lent to it.
class PredictionStudy {
 public:
  // `window_step`: frames from one window to the next.
  PredictionStudy(std::filesystem::path data, int window_step, core::ParallelFor parallel,
                  Progress& progress);

  // Reads the corpus on first use.
  absl::StatusOr<const Corpus*> LoadedCorpus();
  int window_step() const { return window_step_; }

  // Each clip of the training half held out in turn: one MethodForecasts a method.
  absl::StatusOr<const std::vector<MethodForecasts>*> LeaveOneOut();
  // The training half learned, the test half forecast. Empty where there is no test half.
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
