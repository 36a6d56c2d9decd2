// Predictions from one moment of an observation after another, each made when it is asked for. Used
// by one thread at a time; holds on to its model.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/prediction/predict.h"
#include "server/engine/representation.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

struct SeriesOptions {
  core::PredictOptions prediction;
  // Time between two predictions: at least a frame of the database. In smaller steps the series
  // would say the same again.
  double every_seconds = 0;
};

// INVALID_ARGUMENT naming every_seconds.
absl::Status CheckStep(double every_seconds, double frame_rate_hz);

class PredictionSeries {
 public:
  // From options.prediction.at_seconds (absent: history_seconds into the observation, or its end if
  // that comes first) every options.every_seconds to the last frame of the observation.
  // INVALID_ARGUMENT for too many predictions in all; RESOURCE_EXHAUSTED.
  static absl::StatusOr<std::shared_ptr<PredictionSeries>> Open(
      std::shared_ptr<const Snapshot> snapshot, core::StateSequence observation,
      const SeriesOptions& options, const WorkTerms& terms);

  // The next prediction; nothing after the last. Codes as core::Predict; RESOURCE_EXHAUSTED.
  absl::StatusOr<std::optional<core::Prediction>> Next();

  const core::Model& model() const { return snapshot_->model; }
  Calibration calibration() const { return snapshot_->calibration; }

 private:
  PredictionSeries(std::shared_ptr<const Snapshot> snapshot, core::StateSequence observation,
                   const SeriesOptions& options, const WorkTerms& terms, std::int64_t bytes);

  const std::shared_ptr<const Snapshot> snapshot_;
  const core::StateSequence observation_;
  const WorkTerms terms_;
  core::PredictOptions options_;
  const double every_seconds_;
  const double last_seconds_;
  const double first_seconds_;
  const std::int64_t bytes_;  // that one prediction takes, with the observation
  int made_ = 0;
};

}  // namespace motiondb::server
