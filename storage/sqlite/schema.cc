#include "storage/sqlite/schema.h"

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "core/motion/error.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/sqlite_connection.h"

namespace motiondb::storage {
namespace {

// SQL definition of each table, index, trigger and view by kind and name, without the tables that
// ANALYZE creates. Descending order of kind: tables come before their indices.
using SchemaObjects = std::map<std::string, std::string, std::greater<>>;
absl::StatusOr<SchemaObjects> Definitions(Connection& connection) {
  SchemaObjects definitions;
  Statement object = connection.Query(
      "SELECT type, name, tbl_name, ifnull(sql, '') FROM sqlite_schema "
      "WHERE type <> 'table' OR name NOT IN ('sqlite_stat1', 'sqlite_stat4')");
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool row, object.Step());
    if (!row) return definitions;
    definitions[fmt::format("{} '{}'", object.Text(0), object.Text(1))] =
        fmt::format("{}: {}", object.Text(2), object.Text(3));
  }
}

// Returns the definitions of a new store. They are the same for the whole process.
absl::StatusOr<SchemaObjects> ExpectedDefinitions() {
  static Mutex mutex;
  static std::optional<SchemaObjects> expected;
  const MutexLock lock(mutex);
  if (!expected) {
    MOTIONDB_ASSIGN_OR_RETURN(
        const auto fresh,
        SqliteConnection::Open(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
    MOTIONDB_RETURN_IF_ERROR(Migrate(*fresh, Migrations()));
    MOTIONDB_ASSIGN_OR_RETURN(expected, Definitions(*fresh));
  }
  return *expected;
}

}  // namespace

absl::Status Migrate(Connection& connection, std::span<const char* const> migrations) {
  const auto latest = static_cast<std::int64_t>(migrations.size());
  MOTIONDB_ASSIGN_OR_RETURN(const auto version, connection.QueryInteger("PRAGMA user_version"));
  if (version < 0 || version > latest) {
    return core::FailedPrecondition(
        "the store is of version {}, from a newer motiondb; this one supports versions up to {}",
        version, latest);
  }
  if (version == latest) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                            Transaction::Begin(connection, Transaction::Kind::kWrite));
  for (const char* const migration : migrations.subspan(static_cast<std::size_t>(version))) {
    MOTIONDB_RETURN_IF_ERROR(connection.Execute(migration));
  }
  MOTIONDB_RETURN_IF_ERROR(connection.Execute(fmt::format("PRAGMA user_version = {}", latest)));
  return transaction.Commit();
}

absl::Status CheckSchema(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto definitions, Definitions(connection));
  MOTIONDB_ASSIGN_OR_RETURN(const SchemaObjects expected, ExpectedDefinitions());
  for (const auto& [object, definition] : expected) {
    const auto found = definitions.find(object);
    if (found == definitions.end()) return core::DataLoss("the {} is missing", object);
    if (found->second != definition) return core::DataLoss("the {} was changed", object);
  }
  for (const auto& [object, definition] : definitions) {
    if (!expected.contains(object)) return core::DataLoss("unexpected {}", object);
  }
  return absl::OkStatus();
}

}  // namespace motiondb::storage
