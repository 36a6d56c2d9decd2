// Rows of the table `operation`. The functions run in the caller's transaction.
#pragma once

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

}  // namespace motiondb::storage
