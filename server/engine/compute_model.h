// Reads the clips of a database from the store, and computes models from them. Does not store or
// serve models: ModelLifecycle does. Uses only the threads lent to it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
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

// Returns the clips of a database ordered by id, the order that models are built in.
absl::StatusOr<std::vector<storage::ClipRecord>> AllClips(storage::MotionStore& store,
                                                          const std::string& database);

// Returns NewerFormat if a clip has a newer representation: a server of this version can neither
// use nor derive it.
absl::Status CheckNoneIsNewer(const std::vector<storage::ClipRecord>& clips);

// Returns the states of these clips as model input. Skips clips that were deleted meanwhile, and
// corrupt clips, which it records (LiveDatabase::AddUnreadable). CANCELLED if `go_on` returns
// false; it is called before each few clips with the number of clips read. `go_on` may be empty.
absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const core::ParallelFor& parallel, const std::function<bool(std::size_t)>& go_on = {});

// Returns why this server does not know the markers of a database with clips: UNAVAILABLE if
// another server has just stored the first clip; INTERNAL if there are none.
absl::Status UnknownMarkers(storage::MotionStore& store, const std::string& database);

}  // namespace motiondb::server
