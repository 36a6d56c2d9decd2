// The tables of a store and their migrations.
#pragma once

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// SQLite application id of a store: "mtdb".
inline constexpr std::int64_t kApplicationId = 0x6d746462;

// Returns the migration scripts in order. The first makes version 1 from an empty file. A released
// script never changes.
std::span<const char* const> Migrations();

// Migrates the file to version migrations.size(), user_version, in one transaction: if it fails or
// is interrupted, the program that wrote the file can still use it. FAILED_PRECONDITION, changing
// nothing, if the file has a later version.
absl::Status Migrate(Connection& connection, std::span<const char* const> migrations);

// Checks that the definitions of tables, indices, triggers and views are exactly those that
// Migrations() make. DATA_LOSS names the first that differs. For example, a foreign trigger could
// change stored data without notice.
absl::Status CheckSchema(Connection& connection);

}  // namespace motiondb::storage
