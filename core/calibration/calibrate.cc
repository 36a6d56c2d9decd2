#include "core/calibration/calibrate.h"

#include <utility>

#include "core/calibration/prediction_trial.h"
#include "core/calibration/recognition.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::Status Calibrate(Model& model, const ParallelFor& parallel, const BuildProgress& progress) {
  MOTIONDB_ASSIGN_OR_RETURN(RecognitionCalibration recognition,
                            CalibrateRecognition(model, parallel, progress));
  MOTIONDB_ASSIGN_OR_RETURN(PredictionConfidence confidence,
                            FitPredictionConfidence(model, parallel, {}));
  model.set_recognition(std::move(recognition));
  model.set_confidence(std::move(confidence));
  return absl::OkStatus();
}

}  // namespace motiondb::core
