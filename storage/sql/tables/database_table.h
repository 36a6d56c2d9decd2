// Rows of the table `database`. The functions run in the caller's transaction.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

absl::Status InsertDatabase(Connection& connection, const DatabaseRecord& record);
absl::StatusOr<DatabaseRecord> SelectDatabase(Connection& connection, const std::string& name);
absl::StatusOr<std::vector<DatabaseRecord>> SelectDatabases(Connection& connection,
                                                            const Page& page);
// See MotionStore::ListDatabaseStates.
absl::StatusOr<std::vector<DatabaseState>> SelectDatabaseStates(Connection& connection);
// Makes a database invisible and its name free; FreeDeletedDatabases removes its content.
// `id`: see FindDatabase.
absl::Status MarkDatabaseDeleted(Connection& connection, const std::string& name, std::int64_t id);

// Makes a hidden database, with a free name, visible. ALREADY_EXISTS.
absl::Status ShowDatabase(Connection& connection, std::int64_t database_key,
                          const std::string& name);

// Returns the key of a database, which is its id. NOT_FOUND if it does not exist. ABORTED if its id
// is not `id`; 0: any.
absl::StatusOr<std::int64_t> FindDatabase(Connection& connection, const std::string& name,
                                          std::int64_t id = 0);
// ABORTED if the database with this id is deleted.
absl::Status CheckHasDatabase(Connection& connection, std::int64_t id);

// FAILED_PRECONDITION if there is a database: a restore requires a store without databases.
absl::Status CheckHasNoDatabases(Connection& connection);

// Sets the marker set of a database, which its first clip brings. FAILED_PRECONDITION if it has a
// different one.
absl::Status SetMarkerSetText(Connection& connection, std::int64_t database_key,
                              const std::string& text);
// Replaces the marker set of a database. ABORTED if it is not `before`.
absl::Status UpdateMarkerSetText(Connection& connection, const std::string& database,
                                 const std::string& before, const std::string& text);

}  // namespace motiondb::storage
