// A query of one database. Uses the model that is current when it begins: converts the observation
// to states, reserves the memory of the answer and calls core. Options are checked before anything
// is computed. Keeps its database and its model alive.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/estimation/estimate.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"
#include "server/engine/engine.h"
#include "server/engine/observation.h"
#include "server/engine/prediction_series.h"
#include "server/engine/representation.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

class Query {
 public:
  // `database`: id. The engine must outlive the query. NOT_FOUND; FAILED_PRECONDITION if the
  // database has no model.
  static absl::StatusOr<Query> Begin(Engine& engine, const std::string& database,
                                     WorkOptions terms);

  Engine& engine() const { return *engine_; }
  const std::shared_ptr<LiveDatabase>& database() const { return database_; }
  const std::shared_ptr<const Snapshot>& snapshot() const { return snapshot_; }
  const core::Model& model() const { return snapshot_->model; }
  const WorkOptions& terms() const { return terms_; }

  // Converts the observation to states (StatesOf) or to the database's markers (MarkersOf).
  absl::StatusOr<core::StateSequence> States(const Observation& observation) const;
  absl::StatusOr<core::MarkerMotion> Markers(const Observation& observation) const;

  // Like core's functions of the same name. Codes: theirs, those of States, and RESOURCE_EXHAUSTED
  // if the answer takes too much memory. `top_count`: clips and labels in the response for each
  // window; 0: all.
  absl::StatusOr<std::vector<core::RecognizedWindow>> Recognize(
      const Observation& observation, const core::RecognizeOptions& options, int top_count) const;
  absl::StatusOr<core::Estimation> Estimate(const Observation& observation,
                                            const core::EstimateOptions& options) const;
  absl::StatusOr<core::Prediction> Predict(const Observation& observation,
                                           const core::PredictOptions& options) const;
  absl::StatusOr<std::shared_ptr<PredictionSeries>> PredictSeries(
      const Observation& observation, const SeriesOptions& options) const;

 private:
  Query(Engine& engine, std::shared_ptr<LiveDatabase> database,
        std::shared_ptr<const Snapshot> snapshot, WorkOptions terms)
      : engine_(&engine),
        database_(std::move(database)),
        snapshot_(std::move(snapshot)),
        terms_(std::move(terms)) {}

  Engine* engine_;
  std::shared_ptr<LiveDatabase> database_;
  std::shared_ptr<const Snapshot> snapshot_;
  WorkOptions terms_;
};

}  // namespace motiondb::server
