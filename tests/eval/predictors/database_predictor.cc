#include "tests/eval/predictors/database_predictor.h"

#include "core/motion/error.h"
#include "tests/eval/database_model.h"

namespace motiondb::tests {
namespace {

std::vector<DatabasePredictionSetting> DatabasePredictionSettings() {
  return {{"motiondb", "the server's defaults", {}},
          {"motiondb, PAPER",
           "the server's defaults for this method",
           {.method = core::Method::kPaper}}};
}

}  // namespace

absl::Status DatabasePredictor::Fit(const ClipSet& training, const std::vector<double>&) {
  MOTIONDB_ASSIGN_OR_RETURN(model_, BuildEvalModel(set_, training));
  return absl::OkStatus();
}

absl::StatusOr<Forecast> DatabasePredictor::Predict(const core::MarkerMotion& past,
                                                    const std::vector<double>& horizons) const {
  MOTIONDB_ASSIGN_OR_RETURN(const core::StateSequence states, core::ComputeStates(set_, past));
  core::PredictOptions options = setting_.options;
  options.history_seconds = static_cast<double>(past.positions_m.rows()) / past.frame_rate_hz;
  options.horizon_seconds = horizons;
  MOTIONDB_ASSIGN_OR_RETURN(const core::Prediction prediction,
                            core::Predict(*model_, states, options));
  Forecast forecast;
  forecast.positions_m.resize(static_cast<Eigen::Index>(horizons.size()), past.positions_m.cols());
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const core::PredictedFrame& frame = prediction.horizons[h];
    forecast.positions_m.row(static_cast<Eigen::Index>(h)) = frame.marker_positions_m.transpose();
    if (setting_.options.method == core::Method::kBest) {
      forecast.confidence.push_back(frame.confidence.value_or(0));
    }
  }
  return forecast;
}

double DatabasePredictor::model_bytes() const { return ModelBytes(*model_); }

std::vector<PredictionMethod> DatabasePredictionMethods(const core::MarkerSet& set) {
  std::vector<PredictionMethod> methods;
  for (const DatabasePredictionSetting& setting : DatabasePredictionSettings()) {
    methods.push_back({setting.name, [set, setting] {
                         return std::make_unique<DatabasePredictor>(set, setting);
                       }});
  }
  return methods;
}

}  // namespace motiondb::tests
