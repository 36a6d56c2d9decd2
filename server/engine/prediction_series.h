// Predictions from one moment of an observation after another, each made when it is asked for. Used
// by one thread at a time; holds on to its model.
#pragma once

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/prediction/predict.h"
#include "server/engine/live_database.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

class PredictionSeries {
 public:
  // From options.at_seconds (absent: history_seconds into the observation, or its end if that comes
  // first) every `every_seconds` to the last frame of the observation.
  PredictionSeries(std::shared_ptr<const Snapshot> snapshot, core::StateSequence observation,
                   const core::PredictOptions& options, double every_seconds);

  // The next prediction; nothing after the last. Codes as core::Predict.
  absl::StatusOr<std::optional<core::Prediction>> Next(const core::Cancelled& cancelled);

  const core::Model& model() const { return snapshot_->model; }

 private:
  const std::shared_ptr<const Snapshot> snapshot_;
  const core::StateSequence observation_;
  core::PredictOptions options_;
  const double every_seconds_;
  const double last_seconds_;
  double first_seconds_;
  int made_ = 0;
};

}  // namespace motiondb::server
