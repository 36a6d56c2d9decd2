// Rows of the table `server`: the servers that share the store; see MotionStore. The functions run
// in the caller's transaction.
#pragma once

#include <chrono>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/records.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Adds or renews a server, and removes those that have expired.
absl::Status PutServer(Connection& connection, const ServerAddress& server,
                       std::chrono::milliseconds duration);
// In order of name.
absl::StatusOr<std::vector<ServerAddress>> SelectServers(Connection& connection);

}  // namespace motiondb::storage
