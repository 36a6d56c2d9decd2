// Predictions from successive moments of an observation, each computed on demand. Used by one
// thread at a time; keeps its model alive.
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
  // Time between two predictions: at least one frame of the database. Smaller steps would repeat
  // the same prediction.
  double every_seconds = 0;
};

// Returns INVALID_ARGUMENT, naming every_seconds, if the step is too small.
absl::Status CheckStep(double every_seconds, double frame_rate_hz);

class PredictionSeries {
 public:
  // Predicts every options.every_seconds, from options.prediction.at_seconds to the last frame of
  // the observation. Default start: history_seconds into the observation, or its end if that is
  // earlier. INVALID_ARGUMENT for too many predictions in total; RESOURCE_EXHAUSTED.
  static absl::StatusOr<std::shared_ptr<PredictionSeries>> Open(
      std::shared_ptr<const Snapshot> snapshot, core::StateSequence observation,
      const SeriesOptions& options, const WorkOptions& terms);

  // Returns the next prediction; nullopt after the last. Codes as core::Predict;
  // RESOURCE_EXHAUSTED.
  absl::StatusOr<std::optional<core::Prediction>> Next();

  const core::Model& model() const { return snapshot_->model; }
  const Snapshot& snapshot() const { return *snapshot_; }

 private:
  PredictionSeries(std::shared_ptr<const Snapshot> snapshot, core::StateSequence observation,
                   const SeriesOptions& options, const WorkOptions& terms, std::int64_t bytes);

  const std::shared_ptr<const Snapshot> snapshot_;
  const core::StateSequence observation_;
  const WorkOptions terms_;
  core::PredictOptions options_;
  const double every_seconds_;
  const double last_seconds_;
  const double first_seconds_;
  const std::int64_t bytes_;  // memory of one prediction, with the observation
  int made_ = 0;
};

}  // namespace motiondb::server
