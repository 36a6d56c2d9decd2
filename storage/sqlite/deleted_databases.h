// Frees what deleted databases left on the disk, a few megabytes in a transaction. Functions keep
// no state.
#pragma once

#include <functional>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// Runs a piece of work in a transaction of its own that may write; one that fails changes nothing.
using WriteOnce =
    std::function<absl::Status(const std::function<absl::Status(Connection&)>& piece)>;

// As MotionStore::PurgeDeletedDatabases, in pieces. `cancelled` is asked between them.
absl::Status FreeDeletedDatabases(const WriteOnce& write, const core::Cancelled& cancelled);

}  // namespace motiondb::storage
