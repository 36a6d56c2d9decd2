// Builds the model of a database from all of its clips, stores it and lets it answer queries.
#pragma once

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "server/engine/live_database.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// Returns the version of the model that is current then: the one there was, if it was built from
// the clips there are; 0 where no clip is left. Queries are answered by the previous model until
// the new one is stored. Takes as long as a build; thread-safe, but the caller runs one a database
// at a time. Codes: CANCELLED (progress said stop), NOT_FOUND (the database was deleted), and those
// of the store and of core::BuildModel.
absl::StatusOr<int> Rebuild(storage::MotionStore& store, LiveDatabase& database,
                            const core::ParallelFor& parallel, const core::BuildProgress& progress);

}  // namespace motiondb::server
