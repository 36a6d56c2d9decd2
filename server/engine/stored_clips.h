// The clips of a database, as they are read from the store. Safe to call from any thread.
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

// The clips in order of id, the order that models are built in.
absl::StatusOr<std::vector<storage::ClipRecord>> AllClips(storage::MotionStore& store,
                                                          const std::string& database);

// The states of these clips as a model takes them. Leaves out a clip that was deleted meanwhile,
// and one that is corrupt, which the database then knows (LiveDatabase::NoteUnreadable). CANCELLED
// if `go_on`, asked before each with how many were read, returns false; empty: nobody is asked.
absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const std::function<bool(std::size_t)>& go_on = {});

}  // namespace motiondb::server
