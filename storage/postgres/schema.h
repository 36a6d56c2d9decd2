// The tables of a PostgreSQL store and their migrations.
#pragma once

#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// SQL scripts: number i, from 0, makes version i + 1 of the store. Stored: never change one of a
// released version.
std::span<const char* const> PostgresMigrations();

struct SchemaVersions {
  std::int64_t before = 0;  // 0: the database had no store
  std::int64_t now = 0;
};

// Creates or upgrades the tables, in one transaction, under an advisory lock: of several servers
// that start together, one migrates. FAILED_PRECONDITION, changing nothing, if the store is of a
// newer version, or if the database has another encoding than UTF-8 or other tables of these names.
// `version`: for tests, the version to make; 0: the latest.
absl::StatusOr<SchemaVersions> MigratePostgres(Connection& connection, std::int64_t version = 0);

// FAILED_PRECONDITION if a migration into this database (storage/migration) is not complete.
absl::Status CheckIsComplete(Connection& connection);

// FAILED_PRECONDITION if the store does not have the current version. In the caller's transaction.
absl::Status CheckPostgresVersion(Connection& connection);

}  // namespace motiondb::storage
