// A model with its version and figures. Immutable; queries share it and hold on to it.
#pragma once

#include <memory>

#include "core/model/model.h"
#include "storage/records.h"

namespace motiondb::server {

// Whose calibration the answers of a model rest on (core/calibration/calibrate.h).
enum class Calibration {
  kOwn,
  kPrevious,  // that of the model before it, until its own is known
  kTypical,   // core::RecognitionCalibration's and core::PredictionConfidence's defaults: there was
              // no model before it
};

struct Snapshot {
  // As stored; or the figures of a model that is not stored yet, which has no version of its own:
  // it has that of the last stored model, 0 if there is none.
  storage::ModelRecord record;
  core::Model model;
  Calibration calibration = Calibration::kOwn;
  // Whether clips are added to it without a build (EngineOptions::extend_from).
  bool takes_clips = false;

  // Only a model with its own calibration is stored.
  bool is_stored() const { return calibration == Calibration::kOwn; }
};

using SnapshotPointer = std::shared_ptr<const Snapshot>;

}  // namespace motiondb::server
