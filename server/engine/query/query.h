// Queries of one database, and series of predictions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/estimation/estimate.h"
#include "core/prediction/predict.h"
#include "core/recognition/find_motion.h"
#include "core/recognition/recognize.h"
#include "server/engine/engine.h"
#include "server/engine/query/observation.h"
#include "server/engine/snapshot.h"
#include "server/engine/work/work_options.h"

namespace motiondb::server {

struct SeriesOptions {
  core::PredictOptions prediction;
  // Time between two predictions: at least one frame of the database. Smaller steps would repeat
  // the same prediction.
  double every_seconds = 0;
};

// Returns INVALID_ARGUMENT, naming every_seconds, if the step is too small.
absl::Status CheckStep(double every_seconds, double frame_rate_hz);

// Predictions from successive moments of an observation, each computed on demand. Used by one
// thread at a time; keeps its model alive.
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

// What a query requires of the model, and which clips it uses.
struct QueryScope {
  std::string filter = {};        // of clips (server/filter/filter.h); empty: all
  std::int64_t min_revision = 0;  // that the model must contain; 0: none
};

// The motion to find.
struct SoughtMotion {
  std::variant<Observation, std::string> source;  // or a clip id
  core::TimeRange part;
};

// A query of one database. Uses the model that is current when it begins: converts the observation
// to states, reserves the memory of the answer and calls core. Options are checked before anything
// is computed. Keeps its database and its model alive.
class Query {
 public:
  // `database`: id. The engine must outlive the query. NOT_FOUND; FAILED_PRECONDITION if the
  // database has no model, or with reason FILTER_MATCHES_NOTHING; INVALID_ARGUMENT naming the field
  // of the scope; AwaitsChange if the model does not contain the revision yet.
  static absl::StatusOr<Query> Begin(Engine& engine, const std::string& database, WorkOptions terms,
                                     const QueryScope& scope = {});

  Engine& engine() const { return *engine_; }
  const std::shared_ptr<LiveDatabase>& database() const { return database_; }
  const SnapshotPointer& snapshot() const { return served_.snapshot; }
  const core::Model& model() const { return served_.snapshot->model; }
  // Revision of the database that the model contains.
  std::int64_t revision() const { return served_.revision; }
  // Mask of the clips that pass the filter; null: all.
  const std::shared_ptr<const core::ClipMask>& mask() const { return mask_; }
  const WorkOptions& terms() const { return terms_; }

  // Goes on with the model that is current now, and its clips that pass the filter. Returns whether
  // model or mask changed. FAILED_PRECONDITION as for Begin.
  absl::StatusOr<bool> UseCurrentModel(const Filter& filter);

  // Converts the observation to states (StatesOf) or to the database's markers (MarkersOf).
  absl::StatusOr<core::StateSequence> States(const Observation& observation) const;
  absl::StatusOr<core::MarkerMotion> Markers(const Observation& observation) const;

  // Like core's functions of the same name, with the mask of the query. Codes: theirs, those of
  // States, and RESOURCE_EXHAUSTED if the answer takes too much memory. `top_count`: clips in the
  // response for each window; 0: all.
  absl::StatusOr<std::vector<core::RecognizedWindow>> Recognize(const Observation& observation,
                                                                core::RecognizeOptions options,
                                                                int top_count) const;
  absl::StatusOr<core::Estimation> Estimate(const Observation& observation,
                                            core::EstimateOptions options) const;
  // `motion`: a part of the observation, or of a clip. Errors about the part name its fields in
  // FindRequest.
  absl::StatusOr<std::vector<core::MotionMatch>> Find(const SoughtMotion& motion,
                                                      core::FindOptions options) const;
  absl::StatusOr<core::Prediction> Predict(const Observation& observation,
                                           core::PredictOptions options) const;
  absl::StatusOr<std::shared_ptr<PredictionSeries>> PredictSeries(const Observation& observation,
                                                                  SeriesOptions options) const;

 private:
  Query(Engine& engine, std::shared_ptr<LiveDatabase> database, WorkOptions terms)
      : engine_(&engine), database_(std::move(database)), terms_(std::move(terms)) {}

  Engine* engine_;
  std::shared_ptr<LiveDatabase> database_;
  ServedModel served_;
  std::shared_ptr<const core::ClipMask> mask_;
  WorkOptions terms_;
};

}  // namespace motiondb::server
