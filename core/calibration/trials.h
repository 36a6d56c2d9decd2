// What a model's answers are worth, tried on its own clips, each held out in turn. Safe to call
// from any thread; uses only the threads lent to it.
#pragma once

#include <algorithm>
#include <functional>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Runs trial(0) ... trial(count - 1), each writing its result to a place of its own. CANCELLED if
// `progress` returns false.
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

// Predicts at some two hundred moments at most, of stored clips (SampleClips), each without the
// clip it is of, and at some of them again without the second around them alone, for motion is
// often like what is stored of the same person; and fits an error law to each horizon of a query by
// default. No laws where the database has one clip or the clips are too short. The same for any
// number of threads. CANCELLED.
absl::StatusOr<PredictionConfidence> FitPredictionConfidence(const Model& model,
                                                             const ParallelFor& parallel,
                                                             const BuildProgress& progress);

class Model;

// How many of the clips asked about are also tried as whole observations of at most `longest`
// frames, in a model of `clips` clips (> 0) and `frames` frames: 64, or fewer in a model of very
// long clips, but at least 8. It bounds the time of the calibration.
int ClipsTriedWhole(int clips, double frames, double longest);

// Recognizes at most 128 stored clips (SampleClips), each with the model of the other clips
// (LeftOutWith): some 512 windows of 0.4 s, and of ClipsTriedWhole clips the first 10 to 100 % of
// the clip, or of its first 20 s, as whole observations. A clip with a label of its own calibrates
// the familiarity only. A calibration without samples keeps its default. Returns CANCELLED if
// `progress` returns false.
absl::StatusOr<RecognitionCalibration> CalibrateRecognition(const Model& model,
                                                            const ParallelFor& parallel,
                                                            const BuildProgress& progress);

}  // namespace motiondb::core
