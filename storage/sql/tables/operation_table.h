// Rows of the tables `operation` and `build_lease`: operations, and which server may run the builds
// of a database. The functions run in the caller's transaction.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// See MotionStore::PutOperation. NOT_FOUND if the database does not exist.
absl::Status UpsertOperation(Connection& connection, const OperationRecord& record);
absl::StatusOr<OperationRecord> SelectOperation(Connection& connection, const std::string& id);
absl::StatusOr<std::vector<OperationRecord>> SelectOperations(Connection& connection,
                                                              const std::string& database,
                                                              const std::string& before, int limit);
// See MotionStore::ListUnfinishedOperations.
absl::StatusOr<std::vector<OperationRecord>> SelectUnfinishedOperations(Connection& connection);

// Rows of the table `build_lease`, at most one of each database; see MotionStore. In the caller's
// transaction, FindDatabase has found the key of the database: it locks the database, so that
// leases and models of it are stored one after another.

// See MotionStore::AcquireBuildLease. `now_us`: by the clock of the store.
absl::StatusOr<std::int64_t> AcquireLease(Connection& connection, std::int64_t database_key,
                                          const std::string& holder, std::int64_t now_us,
                                          std::int64_t expire_time_us);
absl::Status RenewLease(Connection& connection, std::int64_t database_key, std::int64_t fence,
                        std::int64_t expire_time_us);
absl::Status ReleaseLease(Connection& connection, std::int64_t database_key, std::int64_t fence);

// ABORTED if `fence` is lower than that of the last lease of the database, or of another database;
// 0: it has had none.
absl::Status CheckFence(Connection& connection, std::int64_t database_key, std::int64_t fence);

}  // namespace motiondb::storage
