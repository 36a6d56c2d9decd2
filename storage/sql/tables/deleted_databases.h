// Frees the disk space of deleted databases, a few megabytes per transaction.
#pragma once

#include <functional>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/staged_databases.h"

namespace motiondb::storage {

// Runs `piece` in its own write transaction, which is rolled back on an error.
using TransactionRunner =
    std::function<absl::Status(const std::function<absl::Status(Connection&)>& piece)>;

// See MotionStore::PurgeDeletedDatabases. Leaves the staged ones. Polls `cancelled` between the
// transactions.
absl::Status FreeDeletedDatabases(const TransactionRunner& write, StagedDatabases& staged,
                                  const core::Cancelled& cancelled);

}  // namespace motiondb::storage
