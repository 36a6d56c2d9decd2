#include "storage/postgres/schema.h"

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {
namespace {

// Key of the advisory lock of migrations: "motiondb" in ASCII.
constexpr std::int64_t kMigrationLock = 0x6d6f74696f6e6462;

// Returns the version of the store; 0 if there is none.
absl::StatusOr<std::int64_t> ReadVersion(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto is_there,
      connection.QueryInteger("SELECT count(*) FROM pg_catalog.pg_class WHERE oid = "
                              "to_regclass('motiondb_schema')"));
  if (is_there == 0) return 0;
  return connection.QueryInteger("SELECT version FROM motiondb_schema");
}

absl::Status CheckEncoding(Connection& connection) {
  Statement row = connection.Query("SELECT current_setting('server_encoding')");
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  if (row.Text(0) == "UTF8") return absl::OkStatus();
  return core::FailedPrecondition(
      "the PostgreSQL database has the encoding {}; create one with ENCODING 'UTF8'", row.Text(0));
}

absl::Status IsNewer(std::int64_t version, std::int64_t latest) {
  return core::FailedPrecondition(
      "the store is of version {}, from a newer motiondb; this one supports versions up to {}",
      version, latest);
}

absl::StatusOr<SchemaVersions> Migrate(Connection& connection, std::int64_t latest) {
  // Another server can upgrade for minutes.
  MOTIONDB_RETURN_IF_ERROR(connection.Execute("SET LOCAL lock_timeout = 0"));
  // The lock is of the transaction, because of poolers.
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("SELECT pg_advisory_xact_lock(?)", kMigrationLock).Run());
  MOTIONDB_RETURN_IF_ERROR(CheckEncoding(connection));
  SchemaVersions versions;
  MOTIONDB_ASSIGN_OR_RETURN(versions.before, ReadVersion(connection));
  versions.now = versions.before;
  if (versions.before > latest) return IsNewer(versions.before, latest);
  for (; versions.now < latest; ++versions.now) {
    const absl::Status made =
        connection.Execute(PostgresMigrations()[static_cast<std::size_t>(versions.now)]);
    if (!made.ok()) {
      return absl::Status(
          absl::IsInternal(made) ? absl::StatusCode::kFailedPrecondition : made.code(),
          fmt::format("cannot make version {} of the store: {}", versions.now + 1,
                      std::string(made.message())));
    }
  }
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE motiondb_schema SET version = ?", versions.now).Run());
  return versions;
}

}  // namespace

absl::StatusOr<SchemaVersions> MigratePostgres(Connection& connection, std::int64_t version) {
  const auto latest = version > 0 ? version : std::ssize(PostgresMigrations());
  return InTransaction(connection, Transaction::Kind::kWrite,
                       [&](Connection&) { return Migrate(connection, latest); });
}

absl::Status CheckIsComplete(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto is_marked,
      connection.QueryInteger("SELECT count(*) FROM pg_catalog.pg_class WHERE "
                              "oid = to_regclass('motiondb_migration')"));
  if (is_marked == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "the store is not complete: a migration into it was interrupted or still runs; run the same "
      "`motiondb migrate` again");
}

absl::Status CheckPostgresVersion(Connection& connection) {
  MOTIONDB_RETURN_IF_ERROR(CheckIsComplete(connection));
  const std::int64_t latest = std::ssize(PostgresMigrations());
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t version, ReadVersion(connection));
  if (version == latest) return absl::OkStatus();
  if (version > latest) return IsNewer(version, latest);
  return core::FailedPrecondition(
      "the store is of version {}; a server that may write upgrades it to {}", version, latest);
}

}  // namespace motiondb::storage
