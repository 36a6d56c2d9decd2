// A model with its version, statistics and geometry for pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/motion/execution.h"
#include "core/planning/contacts.h"
#include "core/view/clip_picture.h"
#include "core/view/model_picture.h"
#include "server/engine/work/work_options.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::server {

// The markers of a model as a figure.
struct ModelFigure {
  std::vector<core::BoneEnds> bones;
  core::Feet feet;
};

// Geometry of a model for pictures. Computed on the first use, then shared by all calls; freed with
// the model. Thread-safe.
class ModelView {
 public:
  // Returns the principal axes of the model's states: 12 bytes for each frame. The first caller
  // computes them, on the threads of `parallel` (seconds for 1,000,000 frames); others wait.
  // CANCELLED; the next caller then computes. RESOURCE_EXHAUSTED. REQUIRES, also for Figure: every
  // call is for the same states.
  absl::StatusOr<std::shared_ptr<const core::StateAxes>> Axes(const core::Model& model,
                                                              const core::ParallelFor& parallel,
                                                              const WorkOptions& terms);
  // Light work.
  std::shared_ptr<const ModelFigure> Figure(const core::Model& model);

 private:
  storage::CancellableMutex computing_;  // held while the axes are computed
  storage::Mutex mutex_;
  std::shared_ptr<const core::StateAxes> axes_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const ModelFigure> figure_ ABSL_GUARDED_BY(mutex_);
};

// Source of a model's calibration (core/calibration/calibrate.h).
enum class Calibration {
  kOwn,
  kPrevious,  // of the previous model, until its own is computed
  kTypical,   // defaults of core::RecognitionCalibration and core::PredictionConfidence: there was
              // no previous model
};

// A model with its version and statistics. Immutable; queries share ownership.
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
