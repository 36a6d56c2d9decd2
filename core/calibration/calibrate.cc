#include "core/calibration/calibrate.h"

#include <utility>

#include "core/calibration/trials.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress) {
  const auto half_progress = [&](double begin) -> BuildProgress {
    return [&progress, begin](double fraction, std::string_view stage) {
      return !progress || progress(begin + fraction / 2, stage);
    };
  };
  MOTIONDB_ASSIGN_OR_RETURN(RecognitionCalibration recognition,
                            CalibrateRecognition(model, parallel, half_progress(0)));
  MOTIONDB_ASSIGN_OR_RETURN(PredictionConfidence confidence,
                            FitPredictionConfidence(model, parallel, half_progress(0.5)));
  model.set_recognition(std::move(recognition));
  model.set_confidence(std::move(confidence));
  return absl::OkStatus();
}

absl::StatusOr<Model> RefitLabels(Model model, const ParallelFor& parallel,
                                  const BuildProgress& progress) {
  constexpr double kMetricShare = 0.2;  // of the time
  if (progress && !progress(0, "metric")) return absl::CancelledError("the refit was cancelled");
  ModelParts parts = std::move(model).TakeParts();
  parts.metric = FitMotionMetric(parts, parallel);
  parts.recognition = {};
  parts.confidence = {};
  MOTIONDB_ASSIGN_OR_RETURN(Model refitted, Model::Create(std::move(parts), parallel));
  const auto rest = [&](double fraction, std::string_view stage) {
    return !progress || progress(kMetricShare + (1 - kMetricShare) * fraction, stage);
  };
  MOTIONDB_RETURN_IF_ERROR(Calibrate(refitted, parallel, rest));
  return refitted;
}

}  // namespace motiondb::core
