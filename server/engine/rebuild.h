// Builds the model of a database from all of its clips, stores it and lets it answer queries.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/model/model_builder.h"
#include "server/engine/live_database.h"
#include "server/engine/options.h"
#include "storage/motion_store.h"

namespace motiondb::server {

struct Rebuilt {
  int version = 0;  // of the model that then knows the clips; 0 where no clip is left
  // Where the model took the place of one that was extended by clips: what the build changed, for a
  // person.
  std::string difference;
};

// Makes the model know the clips there are. New ones are made known to the previous model first
// (Extend), which answers queries until the new one is stored; where no clip was deleted and it has
// not drifted (HasDrifted), it stays, and its version is returned. Else takes as long as a build.
// Clips that come during the build are made known to the new model before it answers. Clips that
// are damaged are left out; DATA_LOSS if no other is left. Thread-safe, but the caller runs one a
// database at a time. `stopped` is asked often, from the threads of `parallel`. Codes: CANCELLED
// (stopped, or progress said so), NOT_FOUND (the database was deleted), and those of the store and
// of core::BuildModel.
absl::StatusOr<Rebuilt> Rebuild(storage::MotionStore& store, LiveDatabase& database,
                                const EngineOptions& options, const core::ParallelFor& parallel,
                                const core::BuildProgress& progress,
                                const core::Cancelled& stopped);

}  // namespace motiondb::server
