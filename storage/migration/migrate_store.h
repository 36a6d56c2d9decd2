// Copies a whole store into another: between a file and PostgreSQL, in both directions, without a
// server.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "core/motion/execution.h"

namespace motiondb::storage {

struct MigrationProgress {
  enum class Phase { kCopy, kIndex, kCompare, kPublish };
  Phase phase = Phase::kCopy;
  std::int64_t bytes = 0;     // of blobs that this call has copied or compared
  bool is_continued = false;  // an interrupted migration continues
};

// Copies all rows of the store `from` into the empty store `to` (paths of files or URLs), compares
// all rows of both, and only then lets servers open `to`. After an interruption at any point, the
// same call continues. The source does not change.
//
// FAILED_PRECONDITION if `to` has content that is not of this migration, a server uses one of them,
// or `from` has not the current version. DATA_LOSS if a row or its copy is corrupt, or `from` was
// changed since the migration began. CANCELLED. `on_progress` is called often; it may be empty.
absl::Status MigrateStore(const std::string& from, const std::string& to,
                          const std::function<void(const MigrationProgress&)>& on_progress,
                          const core::Cancelled& cancelled);

}  // namespace motiondb::storage
