// Ids that are not taken. Runs in the transaction of its caller.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// `wanted`, or the first of "wanted-2", "wanted-3", ... for which `taken_sql`, a query with the
// parameters database_key and id, gives no row.
absl::StatusOr<std::string> FreeId(Connection& connection, std::string_view taken_sql,
                                   std::int64_t database_key, const std::string& wanted);

}  // namespace motiondb::storage
