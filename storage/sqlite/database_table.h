// Rows of the table `database`. Functions keep no state; they run in the transaction of their
// caller.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

absl::Status InsertDatabase(Connection& connection, const DatabaseRecord& record);
absl::StatusOr<DatabaseRecord> SelectDatabase(Connection& connection, const std::string& name);
absl::StatusOr<std::vector<DatabaseRecord>> SelectDatabases(Connection& connection,
                                                            const Page& page);
// Gone for all that looks for it by its name; FreeDeletedDatabases removes it.
absl::Status MarkDatabaseDeleted(Connection& connection, const std::string& name);

// NOT_FOUND.
absl::StatusOr<std::int64_t> FindDatabase(Connection& connection, const std::string& name);

// FAILED_PRECONDITION if there is a database: a backup is restored into a store without any.
absl::Status CheckWithoutDatabases(Connection& connection);

// Gives a database the marker set that its first clip brings. FAILED_PRECONDITION if it has
// another.
absl::Status SetMarkerSetText(Connection& connection, std::int64_t database_key,
                              const std::string& text);

}  // namespace motiondb::storage
