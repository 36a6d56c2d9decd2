// Calibrates recognition and prediction with trials on held-out stored clips.
#pragma once

#include <algorithm>
#include <functional>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Runs trial(0) to trial(count - 1) in parallel. A trial writes only its own result. CANCELLED if
// `progress` returns false.
inline absl::Status RunTrials(int count, std::string_view stage, const ParallelFor& parallel,
                              const BuildProgress& progress,
                              const std::function<void(int)>& trial) {
  constexpr int kBatchSize = 32;
  for (int begin = 0; begin < count; begin += kBatchSize) {
    if (progress && !progress(static_cast<double>(begin) / count, stage)) {
      return absl::CancelledError("the calibration was cancelled");
    }
    parallel(std::min(kBatchSize, count - begin), [&](int i) { trial(begin + i); });
  }
  return absl::OkStatus();
}

class Model;

// Predicts from at most 192 moments of at most 128 stored units (SampleUnits), with the moment's
// clip left out. Repeats half of the predictions with only 1 s before and after the moment left
// out. Fits an error model for each default horizon with at least 16 predictions; there is none if
// the model has one clip or only short clips. The result does not depend on the number of threads.
// CANCELLED if `progress` returns false.
absl::StatusOr<PredictionConfidence> FitPredictionConfidence(const Model& model,
                                                             const ParallelFor& parallel,
                                                             const BuildProgress& progress);

// Returns how many units of a model with `clips` clips (> 0) and `frames` frames to recognize as
// whole observations of at most `max_frames` frames: 8 to 64, and fewer for longer clips, to bound
// the time of the calibration.
int ClipsTriedWhole(int clips, double frames, double max_frames);

// Recognizes at most 128 stored units (SampleUnits) with the model without their clips
// (LeftOutWith):
// - at most 512 windows of 0.4 s;
// - of ClipsTriedWhole units, the first 10 to 100 % as whole observations, within the first 20 s.
// If no remaining unit has the label of a unit, it calibrates only the familiarity. A weight
// without samples keeps its default. CANCELLED if `progress` returns false.
absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress);

}  // namespace motiondb::core
