// A model with its version and statistics. Immutable; queries share ownership.
#pragma once

#include <cstdint>
#include <memory>

#include "core/model/model.h"
#include "server/engine/model_view.h"
#include "storage/records.h"

namespace motiondb::server {

// Source of a model's calibration (core/calibration/calibrate.h).
enum class Calibration {
  kOwn,
  kPrevious,  // of the previous model, until its own is computed
  kTypical,   // defaults of core::RecognitionCalibration and core::PredictionConfidence: there was
              // no previous model
};

struct Snapshot {
  // As stored. A model that is not stored yet has the version of the last stored model, 0 if there
  // is none.
  storage::ModelRecord record;
  core::Model model;
  Calibration calibration = Calibration::kOwn;
  // Whether clips can be added without a build (EngineOptions::extend_from).
  bool is_extensible = false;
  // False: labels changed since metric and calibration were fitted.
  bool has_fitted_labels = true;
  // Geometry for pictures, computed on demand; it depends on the states and the tree only.
  std::shared_ptr<ModelView> view = std::make_shared<ModelView>();

  // Only a model with its own calibration is stored.
  bool is_stored() const { return calibration == Calibration::kOwn; }
};

using SnapshotPointer = std::shared_ptr<const Snapshot>;

// The model that answers queries.
struct ServedModel {
  SnapshotPointer snapshot;  // null: none
  // It contains all changes of the database up to this revision.
  std::int64_t revision = 0;
  // The stored model, if it is not in memory; `snapshot` is then null.
  std::shared_ptr<const storage::ModelRecord> unloaded = nullptr;

  // The record of the model, in memory or not; null: there is no model.
  const storage::ModelRecord* record() const {
    return snapshot != nullptr ? &snapshot->record : unloaded.get();
  }
};

}  // namespace motiondb::server
