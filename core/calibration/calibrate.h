// Calibrates the probabilities of a model's answers with trials on held-out stored clips: a
// calibrated probability equals the observed frequency.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/model/model_builder.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
struct LabelUnit;

// Calibrates a model that is built and not yet shared. Uses at most 128 stored clips, to bound the
// time. The result does not depend on the number of threads. CANCELLED if `progress` returns false;
// the model is then unchanged.
absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress);

// Returns the model with everything that depends on labels fitted again: metric, stored frames and
// index in the metric, and the calibration. Tree, node statistics, graphs, scale and motion prior
// stay. For a model without extension it equals BuildModel and Calibrate of the same clips with
// their present labels. CANCELLED if `progress` returns false.
absl::StatusOr<Model> RefitLabels(Model model, const ParallelFor& parallel,
                                  const BuildProgress& progress);

// Held-out units (core/model/label_units.h): which clips a test leaves out, and their motion.

// Returns for each clip whether a test of a unit leaves it out. If the subject is known and other
// subjects have units with the same label, all clips of the subject are left out, because the
// subject would reveal the label. If not, only the unit's clip is left out.
std::vector<bool> LeftOutWith(const Model& model, const LabelUnit& held_out);

// Returns the mask of the other clips; null if all are left out.
std::shared_ptr<const ClipMask> MaskWithout(const Model& model, std::vector<bool> left_out);

// Returns at most `max_count` units of kActionTrack, ordered by label and subject, with the
// proportions of labels and subjects of the model. Evenly spread elements of the result also have
// these proportions. They do not depend on the order of the clips in the model.
std::vector<LabelUnit> SampleUnits(const Model& model, int max_count);

// Returns the unscaled states of a stored clip or unit, or of frames [first, end) of a clip.
StateSequence StoredMotion(const Model& model, int clip);
StateSequence StoredMotion(const Model& model, const LabelUnit& unit);
StateSequence StoredMotion(const Model& model, int clip, int first, int end);

// The trials of Calibrate.

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
