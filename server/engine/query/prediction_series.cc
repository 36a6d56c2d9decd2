#include "server/engine/query/prediction_series.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "server/engine/query/query_memory.h"

namespace motiondb::server {
namespace {

// A series is a long call: it yields to other clients after each moment, and its total size is
// limited.
constexpr double kMaxPredictions = 1 << 18;

absl::Status CheckCount(const core::StateSequence& states, const SeriesOptions& options) {
  const std::size_t horizons = options.prediction.horizon_seconds.size();
  const double moments = 1 + states.frame_count() / states.frame_rate_hz / options.every_seconds;
  if (moments * static_cast<double>(horizons) <= kMaxPredictions) return absl::OkStatus();
  return core::FieldViolation(
      "every_seconds",
      "expected at most {2:.0f} predictions in total, got {0:.0f} moments with {1} horizons each: "
      "use fewer horizons, longer steps or a shorter observation",
      std::floor(moments), horizons, kMaxPredictions);
}

}  // namespace

absl::Status CheckStep(double every_seconds, double frame_rate_hz) {
  constexpr double kRounding = 1e-3;  // accepts 0.0167 s as one frame at 60 Hz
  if (every_seconds >= (1 - kRounding) / frame_rate_hz && std::isfinite(every_seconds)) {
    return absl::OkStatus();
  }
  return core::FieldViolation("every_seconds",
                              "expected at least one frame of the database, {:.6f} s, got {}",
                              1 / frame_rate_hz, every_seconds);
}

absl::StatusOr<std::shared_ptr<PredictionSeries>> PredictionSeries::Open(
    std::shared_ptr<const Snapshot> snapshot, core::StateSequence observation,
    const SeriesOptions& options, const WorkOptions& terms) {
  MOTIONDB_RETURN_IF_ERROR(CheckCount(observation, options));
  const std::int64_t bytes = BytesToPredict(snapshot->model, observation, options.prediction);
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(bytes));
  return std::shared_ptr<PredictionSeries>(
      new PredictionSeries(std::move(snapshot), std::move(observation), options, terms, bytes));
}

PredictionSeries::PredictionSeries(std::shared_ptr<const Snapshot> snapshot,
                                   core::StateSequence observation, const SeriesOptions& options,
                                   const WorkOptions& terms, std::int64_t bytes)
    : snapshot_(std::move(snapshot)),
      observation_(std::move(observation)),
      terms_(terms),
      options_(options.prediction),
      every_seconds_(options.every_seconds),
      last_seconds_(std::max(0, observation_.frame_count() - 1) / observation_.frame_rate_hz),
      first_seconds_(
          options_.at_seconds.value_or(std::min(options_.history_seconds, last_seconds_))),
      bytes_(bytes) {}

absl::StatusOr<std::optional<core::Prediction>> PredictionSeries::Next() {
  const double at = first_seconds_ + made_ * every_seconds_;
  // Moments are rounded to the nearest frame, so rounding must not lose the last one. The first
  // moment is always predicted: if it is outside the observation, core returns the error.
  const double slack = 1e-6 / observation_.frame_rate_hz;
  if (made_ > 0 && at > last_seconds_ + slack) return std::optional<core::Prediction>();
  options_.at_seconds = made_ > 0 ? std::min(at, last_seconds_) : at;
  auto prediction = core::Predict(model(), observation_, options_, terms_.cancelled);
  if (!prediction.ok()) return core::Within("prediction", prediction.status());
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(bytes_ + BytesOfClipNames(*prediction)));
  ++made_;
  return std::optional<core::Prediction>(*std::move(prediction));
}

}  // namespace motiondb::server
