#include "server/engine/query.h"

#include <utility>

#include "core/motion/error.h"
#include "server/engine/query_memory.h"

namespace motiondb::server {

absl::StatusOr<Query> Query::Begin(Engine& engine, const std::string& database, WorkOptions terms) {
  MOTIONDB_ASSIGN_OR_RETURN(auto live, engine.FindDatabase(database));
  MOTIONDB_ASSIGN_OR_RETURN(auto snapshot, engine.CurrentModel(*live));
  return Query(engine, std::move(live), std::move(snapshot), std::move(terms));
}

absl::StatusOr<core::StateSequence> Query::States(const Observation& observation) const {
  return StatesOf(observation, *database_, engine_->skeletons(), engine_->options().max_frames,
                  terms_);
}

absl::StatusOr<core::MarkerMotion> Query::Markers(const Observation& observation) const {
  return MarkersOf(observation, *database_, engine_->skeletons(), engine_->options().max_frames,
                   terms_);
}

absl::StatusOr<std::vector<core::RecognizedWindow>> Query::Recognize(
    const Observation& observation, const core::RecognizeOptions& options, int top_count) const {
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(options));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, States(observation));
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(BytesToRecognize(model(), states, options, top_count)));
  auto windows = core::Recognize(model(), states, options, terms_.cancelled);
  if (!windows.ok()) return windows;
  for (const core::RecognizedWindow& window : *windows) {
    database_->CountWindow(window.unknown_probability);
  }
  return windows;
}

absl::StatusOr<core::Estimation> Query::Estimate(const Observation& observation,
                                                 const core::EstimateOptions& options) const {
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(options.search));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, States(observation));
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(BytesToEstimate(model(), states, options)));
  return core::Estimate(model(), states, options, terms_.cancelled);
}

absl::StatusOr<core::Prediction> Query::Predict(const Observation& observation,
                                                const core::PredictOptions& options) const {
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(options));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, States(observation));
  const std::int64_t bytes = BytesToPredict(model(), states, options);
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(bytes));
  auto prediction = core::Predict(model(), states, options, terms_.cancelled);
  if (!prediction.ok()) return prediction;
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(bytes + BytesOfClipNames(*prediction)));
  return prediction;
}

absl::StatusOr<std::shared_ptr<PredictionSeries>> Query::PredictSeries(
    const Observation& observation, const SeriesOptions& options) const {
  MOTIONDB_RETURN_IF_ERROR(core::Within("prediction", core::CheckOptions(options.prediction)));
  MOTIONDB_RETURN_IF_ERROR(CheckStep(options.every_seconds, model().settings().frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(auto states, States(observation));
  return PredictionSeries::Open(snapshot_, std::move(states), options, terms_);
}

}  // namespace motiondb::server
