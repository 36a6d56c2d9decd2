// Computes models from the clips in a store. Nothing is stored or served here: ModelLifecycle does
// that. Thread-safe; uses only the threads lent to it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/extend_model.h"
#include "core/model/model_builder.h"
#include "server/engine/live_database.h"
#include "server/engine/snapshot.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// A model of all clips that can be read, not calibrated. `progress` gets its fraction of reading
// and building. ABORTED if all were deleted meanwhile, DATA_LOSS if all are corrupt, CANCELLED if
// progress returned false; and the codes of the store and of core::BuildModel.
absl::StatusOr<core::Model> ModelOfClips(storage::MotionStore& store, LiveDatabase& database,
                                         const std::vector<storage::ClipRecord>& clips,
                                         const core::ParallelFor& parallel,
                                         const core::BuildProgress& progress);

struct ExtendedModel {
  core::Model model;
  core::ModelDrift drift;
};

// `base` with these clips as its last (core::ExtendModel). Nothing if none of them can be read.
absl::StatusOr<std::optional<ExtendedModel>> ModelWithClips(storage::MotionStore& store,
                                                            LiveDatabase& database,
                                                            const core::Model& base,
                                                            const std::vector<std::string>& clips,
                                                            const core::ParallelFor& parallel);

// The figures of a model that is not stored, made now, under the version given.
storage::ModelRecord FiguresOf(const std::string& database, int version, const core::Model& model,
                               double drift_fraction);

// Whether a model has drifted so far from its build that it should be built again
// (core::ModelDrift).
bool HasDrifted(const storage::ModelRecord& record);

// What a build changed, for a person, if it replaces a model that was extended by clips; else
// empty. `before` may be null.
std::string DifferenceText(const Snapshot* before, const core::Model& built,
                           const core::ParallelFor& parallel);

}  // namespace motiondb::server
