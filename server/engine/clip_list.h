// All clips of a database at once, and whether a model was built from just these. Safe to call from
// any thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/engine/live_database.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// The clips in order of id, the order that models are built in.
absl::StatusOr<std::vector<storage::ClipRecord>> AllClips(storage::MotionStore& store,
                                                          const std::string& database);

// Whether the model holds exactly these clips. A clip that came after its build began does not
// count as held, although a clip of that id, since deleted, may have been.
bool IsBuiltFrom(const Snapshot& snapshot, const std::vector<storage::ClipRecord>& clips);

}  // namespace motiondb::server
