// Calibration of recognition and prediction by trials on held-out stored clips.
#pragma once

#include <algorithm>
#include <functional>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Runs trial(0) ... trial(count - 1). Each trial writes its own result. CANCELLED if `progress`
// returns false.
inline absl::Status RunTrials(int count, std::string_view stage, const ParallelFor& parallel,
                              const BuildProgress& progress,
                              const std::function<void(int)>& trial) {
  constexpr int kAtOnce = 32;
  for (int begin = 0; begin < count; begin += kAtOnce) {
    if (progress && !progress(static_cast<double>(begin) / count, stage)) {
      return absl::CancelledError("the calibration was cancelled");
    }
    parallel(std::min(kAtOnce, count - begin), [&](int i) { trial(begin + i); });
  }
  return absl::OkStatus();
}

class Model;

// Predicts from at most 288 moments of at most 128 stored clips (SampleClips), with their own clip
// left out, or only the second around the moment. Fits an error model for each default horizon.
// There are no error models if the database has one clip or if its clips are too short. The result
// does not depend on the number of threads. CANCELLED.
absl::StatusOr<PredictionConfidence> FitPredictionConfidence(const Model& model,
                                                             const ParallelFor& parallel,
                                                             const BuildProgress& progress);

// Returns the number of clips that are also recognized as whole observations of at most
// `max_frames` frames, in a model of `clips` clips (> 0) and `frames` frames: 8 to 64, fewer the
// longer the clips are. It bounds the time of the calibration.
int ClipsTriedWhole(int clips, double frames, double max_frames);

// Recognizes at most 128 stored clips (SampleClips), each in the model without the clip
// (LeftOutWith): at most 512 windows of 0.4 s, and for ClipsTriedWhole clips the first 10 to 100 %
// of the clip, or of its first 20 s, as whole observations. A clip whose label no other clip has
// calibrates only the familiarity. A calibration without samples keeps its default. CANCELLED if
// `progress` returns false.
absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress);

}  // namespace motiondb::core
