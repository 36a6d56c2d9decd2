// The database as a predictor: builds a model and calls core::Predict.
#pragma once

#include <optional>

#include "core/model/model.h"
#include "core/prediction/predict.h"
#include "tests/eval/predictors/predictor.h"

namespace motiondb::tests {

struct DatabasePredictionSetting {
  std::string name;
  std::string chosen;
  core::PredictOptions options;  // the query sets moment, history and horizons
};

class DatabasePredictor : public Predictor {
 public:
  DatabasePredictor(core::MarkerSet set, DatabasePredictionSetting setting)
      : set_(std::move(set)), setting_(std::move(setting)) {}

  absl::Status Fit(const ClipSet& training, const std::vector<double>& horizons) override;
  absl::StatusOr<Forecast> Predict(const core::MarkerMotion& past,
                                   const std::vector<double>& horizons) const override;
  std::string chosen() const override { return setting_.chosen; }
  double model_bytes() const override;

 private:
  const core::MarkerSet set_;
  const DatabasePredictionSetting setting_;
  std::optional<core::Model> model_;
};

// Returns one row per prediction method of the database.
std::vector<PredictionMethod> DatabasePredictionMethods(const core::MarkerSet& set);

}  // namespace motiondb::tests
