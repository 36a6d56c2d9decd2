// Rows of the table `operation`. Functions keep no state; they run in the transaction of their
// caller.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// As MotionStore::PutOperation. NOT_FOUND if there is no such database.
absl::Status UpsertOperation(Connection& connection, const OperationRecord& record);
absl::StatusOr<OperationRecord> SelectOperation(Connection& connection, const std::string& id);
absl::StatusOr<std::vector<OperationRecord>> SelectOperations(Connection& connection,
                                                              const std::string& database,
                                                              const std::string& before, int limit);

}  // namespace motiondb::storage
