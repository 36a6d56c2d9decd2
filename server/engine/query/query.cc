#include "server/engine/query/query.h"

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

namespace {

// Returns OK if the model contains the revision, or AwaitsChange.
absl::Status CheckRevision(Engine& engine, LiveDatabase& live, const WorkOptions& terms,
                           std::int64_t min_revision) {
  if (min_revision == 0) return absl::OkStatus();
  // First, so that no change is missed.
  if (terms.wake_on) terms.wake_on(*live.signal());
  MOTIONDB_ASSIGN_OR_RETURN(const ServedModel served, live.lifecycle().Use());
  if (served.revision >= min_revision) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision,
                            engine.store().annotations().Revision(live.name()));
  if (min_revision < 0 || min_revision > revision) {
    return core::FieldViolation("min_revision",
                                "expected 0 to {}, the revision of the database, got {}", revision,
                                min_revision);
  }
  return AwaitsChange();
}

}  // namespace

absl::StatusOr<Query> Query::Begin(Engine& engine, const std::string& database, WorkOptions terms,
                                   const QueryScope& scope) {
  MOTIONDB_ASSIGN_OR_RETURN(auto live, engine.FindDatabase(database));
  MOTIONDB_ASSIGN_OR_RETURN(const Filter filter,
                            Filter::Parse(scope.filter, FilterSubject::kClips));
  MOTIONDB_RETURN_IF_ERROR(CheckRevision(engine, *live, terms, scope.min_revision));
  Query query(engine, std::move(live), std::move(terms));
  MOTIONDB_RETURN_IF_ERROR(query.UseCurrentModel(filter).status());
  return query;
}

absl::StatusOr<bool> Query::UseCurrentModel(const Filter& filter) {
  MOTIONDB_ASSIGN_OR_RETURN(ServedModel served,
                            engine_->CurrentModelAndRevision(*database_, terms_));
  auto mask = mask_;
  if (!filter.passes_all()) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto catalog,
                              database_->Catalog(engine_->store().annotations()));
    MOTIONDB_ASSIGN_OR_RETURN(mask, database_->masks().Of(served.snapshot, *catalog, filter));
  }
  const bool is_changed = served.snapshot != served_.snapshot || mask != mask_;
  served_ = std::move(served);
  mask_ = std::move(mask);
  return is_changed;
}

absl::StatusOr<core::StateSequence> Query::States(const Observation& observation) const {
  return StatesOf(observation, *database_, engine_->skeletons(), engine_->options().max_frames,
                  terms_);
}

absl::StatusOr<core::MarkerMotion> Query::Markers(const Observation& observation) const {
  return MarkersOf(observation, *database_, engine_->skeletons(), engine_->options().max_frames,
                   terms_);
}

absl::StatusOr<std::vector<core::RecognizedWindow>> Query::Recognize(const Observation& observation,
                                                                     core::RecognizeOptions options,
                                                                     int top_count) const {
  options.mask = mask_;
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(options));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, States(observation));
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(BytesToRecognize(model(), states, options, top_count)));
  auto windows = core::Recognize(model(), states, options, terms_.cancelled);
  if (!windows.ok()) return windows;
  MOTIONDB_RETURN_IF_ERROR(CheckScores(*windows, top_count));
  for (const core::RecognizedWindow& window : *windows) {
    database_->CountWindow(window.unknown_probability);
  }
  return windows;
}

absl::StatusOr<core::Estimation> Query::Estimate(const Observation& observation,
                                                 core::EstimateOptions options) const {
  options.search.mask = mask_;
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(options.search));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, States(observation));
  MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(BytesToEstimate(model(), states, options)));
  return core::Estimate(model(), states, options, terms_.cancelled);
}

absl::StatusOr<std::vector<core::MotionMatch>> Query::Find(const SoughtMotion& motion,
                                                           core::FindOptions options) const {
  options.mask = mask_;
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(options));
  absl::StatusOr<core::MotionPart> part;
  if (const auto* const clip = std::get_if<std::string>(&motion.source)) {
    part = core::PartOfClip(model(), *clip, motion.part);
    if (!part.ok()) return core::Within("clip_range", part.status());
    const auto frames = static_cast<int>(part->states.rows());
    MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(BytesToFind(model(), frames, options)));
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(const auto states, States(std::get<Observation>(motion.source)));
    MOTIONDB_RETURN_IF_ERROR(terms_.Reserve(BytesToFind(model(), states.frame_count(), options)));
    MOTIONDB_ASSIGN_OR_RETURN(part, core::PartOfObservation(model(), states, motion.part));
  }
  return core::FindMotion(model(), *std::move(part), options, terms_.cancelled);
}

absl::StatusOr<core::Prediction> Query::Predict(const Observation& observation,
                                                core::PredictOptions options) const {
  options.mask = mask_;
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
    const Observation& observation, SeriesOptions options) const {
  options.prediction.mask = mask_;
  MOTIONDB_RETURN_IF_ERROR(core::Within("prediction", core::CheckOptions(options.prediction)));
  MOTIONDB_RETURN_IF_ERROR(CheckStep(options.every_seconds, model().settings().frame_rate_hz));
  MOTIONDB_ASSIGN_OR_RETURN(auto states, States(observation));
  return PredictionSeries::Open(served_.snapshot, std::move(states), options, terms_);
}

}  // namespace motiondb::server
