#include "storage/sql/models/model_terms.h"

#include <functional>

#include "core/motion/error.h"
#include "storage/sql/models/model_table.h"
#include "storage/sql/tables/build_lease_table.h"
#include "storage/sql/tables/database_table.h"

namespace motiondb::storage {

absl::Status CheckModelTerms(Connection& connection, const std::string& database,
                             std::int64_t database_key, const ModelTerms& terms) {
  MOTIONDB_RETURN_IF_ERROR(CheckFence(connection, database_key, terms.fence));
  if (!terms.base_version) return absl::OkStatus();
  const auto current = FindCurrentModel(connection, database, database_key);
  if (!current.ok() && !absl::IsNotFound(current.status())) return current.status();
  const int version = current.ok() ? current->version : 0;
  if (version == *terms.base_version) return absl::OkStatus();
  return absl::AbortedError(fmt::format(
      "the model of database '{}' was computed from model {}, but the current one is {}", database,
      *terms.base_version, version));
}

TransactionRunner Fenced(const TransactionRunner& write, const std::string& database,
                         std::int64_t fence) {
  return [&write, &database, fence](const std::function<absl::Status(Connection&)>& piece) {
    return write([&](Connection& connection) -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(const auto database_key, FindDatabase(connection, database));
      MOTIONDB_RETURN_IF_ERROR(CheckFence(connection, database_key, fence));
      return piece(connection);
    });
  };
}

}  // namespace motiondb::storage
