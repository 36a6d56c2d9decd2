// Lets a database's model know clips that were stored since it was made, without a build.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_input.h"
#include "core/tree/parallel.h"
#include "server/engine/live_database.h"
#include "server/engine/options.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// Whether a model has drifted so far from its build that it should be built again
// (core::ModelDrift).
bool HasDrifted(const storage::ModelRecord& record);

// How the model differs from the clips whose states can be read, as far as is known.
absl::StatusOr<storage::ModelGap> FindReadableGap(storage::MotionStore& store,
                                                  const LiveDatabase& database);

// The states of these clips as a model takes them; a clip that was deleted meanwhile is passed
// over, and one that is damaged, which the database then knows. CANCELLED if `go_on`, asked before
// each with how many were read, returns false.
absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const std::function<bool(std::size_t)>& go_on);

// Extends the store's current model, which is `snapshot`, by the clips that it does not know, and
// stores it. Returns `snapshot` itself where there is none such, or it cannot be extended, or was
// built faster than options.extend_from. REQUIRES: model_mutex() of the database is held.
absl::StatusOr<std::shared_ptr<const Snapshot>> ExtendSnapshot(
    storage::MotionStore& store, LiveDatabase& database, std::shared_ptr<const Snapshot> snapshot,
    const EngineOptions& options, const core::ParallelFor& parallel);

// Extends the model that answers queries, if there is one. Thread-safe.
absl::Status Extend(storage::MotionStore& store, LiveDatabase& database,
                    const EngineOptions& options, const core::ParallelFor& parallel);

}  // namespace motiondb::server
