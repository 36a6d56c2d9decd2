#include "storage/sqlite/free_id.h"

#include "core/motion/error.h"

namespace motiondb::storage {

absl::StatusOr<std::string> FreeId(Connection& connection, std::string_view taken_sql,
                                   std::int64_t database_key, const std::string& wanted) {
  std::string id = wanted;
  for (int number = 2;; ++number) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool taken,
                              connection.Query(taken_sql, database_key, id).Step());
    if (!taken) return id;
    id = fmt::format("{}-{}", wanted, number);
  }
}

}  // namespace motiondb::storage
