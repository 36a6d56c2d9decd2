#include "core/calibration/calibrate.h"

#include <utility>

#include "core/calibration/prediction_trial.h"
#include "core/calibration/recognition.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress) {
  const BuildProgress first_half = [&](double fraction, std::string_view stage) {
    return !progress || progress(fraction / 2, stage);
  };
  MOTIONDB_ASSIGN_OR_RETURN(RecognitionCalibration recognition,
                            CalibrateRecognition(model, parallel, first_half));
  if (!first_half(1, "confidence of predictions")) {
    return absl::CancelledError("the calibration was cancelled");
  }
  MOTIONDB_ASSIGN_OR_RETURN(PredictionConfidence confidence,
                            FitPredictionConfidence(model, parallel, {}));
  model.set_recognition(std::move(recognition));
  model.set_confidence(std::move(confidence));
  return absl::OkStatus();
}

}  // namespace motiondb::core
