// All clips of a database at once. Safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// The clips in order of id, the order that models are built in.
absl::StatusOr<std::vector<storage::ClipRecord>> AllClips(storage::MotionStore& store,
                                                          const std::string& database);

}  // namespace motiondb::server
