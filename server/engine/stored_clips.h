// Reads the clips of a database from the store.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/build_input.h"
#include "server/engine/live_database.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// Returns the clips ordered by id, the order that models are built in.
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
