// Computes models from the clips in a store. Does not store or serve them: ModelLifecycle does.
// Uses only the threads lent to it.
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

// Returns an uncalibrated model of all readable clips. `progress` gets the fraction (0 to 1) of
// reading and building. ABORTED if all clips were deleted meanwhile, DATA_LOSS if all are corrupt,
// CANCELLED if `progress` returned false; also the codes of the store and of core::BuildModel.
absl::StatusOr<core::Model> ModelOfClips(storage::MotionStore& store, LiveDatabase& database,
                                         const std::vector<storage::ClipRecord>& clips,
                                         const core::ParallelFor& parallel,
                                         const core::BuildProgress& progress);

struct ExtendedModel {
  core::Model model;
  core::ModelDrift drift;
};

// Returns `base` extended by these clips (core::ExtendModel), which become its last clips. Returns
// nullopt if none of them can be read.
absl::StatusOr<std::optional<ExtendedModel>> ModelWithClips(storage::MotionStore& store,
                                                            LiveDatabase& database,
                                                            const core::Model& base,
                                                            const std::vector<std::string>& clips,
                                                            const core::ParallelFor& parallel);

// Returns the record of a model that is not stored, with the given version and the current time.
storage::ModelRecord ModelRecordOf(const std::string& database, int version,
                                   const core::Model& model, double drift_fraction);

// Returns whether the model's drift requires a new build (core::ModelDrift).
bool HasDrifted(const storage::ModelRecord& record);

// Returns a text for the operator: what the build changed compared with `before`. Empty unless
// `before` was extended by clips. `before` may be null.
std::string DifferenceText(const Snapshot* before, const core::Model& built,
                           const core::ParallelFor& parallel);

}  // namespace motiondb::server
