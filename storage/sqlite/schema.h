// The tables of a store and how they came to be, one migration after another.
#pragma once

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// Tells a store from any other SQLite file: "mtdb".
inline constexpr std::int64_t kApplicationId = 0x6d746462;

// Scripts in order. The first makes version 1 of an empty file. What was released does not change.
std::span<const char* const> Migrations();

// Brings the file to version migrations.size(), each migration and its user_version in a
// transaction of their own. FAILED_PRECONDITION, changing nothing, if the file is of a later
// version.
absl::Status Migrate(Connection& connection, std::span<const char* const> migrations);

// DATA_LOSS, naming the first that differs, unless the tables, indices, triggers and views are
// those, word by word, that all of Migrations() make. A trigger of somebody else's would change
// what is stored behind the server's back.
absl::Status CheckSchema(Connection& connection);

}  // namespace motiondb::storage
