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

}  // namespace motiondb::core
