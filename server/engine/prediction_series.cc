#include "server/engine/prediction_series.h"

#include <algorithm>
#include <utility>

#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::server {

PredictionSeries::PredictionSeries(std::shared_ptr<const Snapshot> snapshot,
                                   core::StateSequence observation,
                                   const core::PredictOptions& options, double every_seconds)
    : snapshot_(std::move(snapshot)),
      observation_(std::move(observation)),
      options_(options),
      every_seconds_(every_seconds),
      last_seconds_(std::max(0, observation_.frame_count() - 1) / observation_.frame_rate_hz),
      first_seconds_(
          options.at_seconds.value_or(std::min(options.history_seconds, last_seconds_))) {}

absl::StatusOr<std::optional<core::Prediction>> PredictionSeries::Next(
    const core::Cancelled& cancelled) {
  const double at = first_seconds_ + made_ * every_seconds_;
  // Moments are taken at the nearest frame, so rounding must not lose the last one. The first is
  // always asked for: one outside the observation is the caller's mistake, and core says so.
  const double slack = 1e-6 / observation_.frame_rate_hz;
  if (made_ > 0 && at > last_seconds_ + slack) return std::optional<core::Prediction>();
  options_.at_seconds = made_ > 0 ? std::min(at, last_seconds_) : at;
  MOTIONDB_ASSIGN_OR_RETURN(core::Prediction prediction,
                            core::Predict(model(), observation_, options_, cancelled));
  ++made_;
  return std::optional<core::Prediction>(std::move(prediction));
}

}  // namespace motiondb::server
