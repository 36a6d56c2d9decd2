#include "storage/migration/migration_end.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "core/motion/error.h"
#include "storage/postgres/postgres_connection.h"
#include "storage/postgres/schema.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/table_lists.h"
#include "storage/sqlite/opening_check.h"
#include "storage/sqlite/store_file.h"
#include "storage/store_url.h"

namespace motiondb::storage {
namespace {

namespace fs = std::filesystem;

// Of the file of a target that is not complete.
constexpr char kUnfinished[] = "-migration";

absl::StatusOr<std::string> AbsolutePath(const std::string& store) {
  std::error_code error;
  const fs::path absolute = fs::absolute(store, error);
  std::string path;
  if (!error) path = fs::weakly_canonical(absolute, error).string();
  if (error) return core::InvalidArgument("cannot open '{}': {}", store, error.message());
  return path;
}

// FAILED_PRECONDITION if another session of motiondb is connected to the database. Sessions that
// were just closed need a moment to end. REQUIRES: no transaction, whose list would not change.
absl::Status CheckIsUnused(Connection& connection, const std::string& name) {
  constexpr int kAttempts = 20;
  std::int64_t sessions = 0;
  for (int i = 0; i < kAttempts; ++i) {
    if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    MOTIONDB_ASSIGN_OR_RETURN(
        sessions,
        connection.QueryInteger("SELECT count(*) FROM pg_stat_activity WHERE datname = "
                                "current_database() AND application_name = 'motiondb' AND pid <> "
                                "pg_backend_pid()"));
    if (sessions == 0) return absl::OkStatus();
  }
  return core::FailedPrecondition(
      "the store {} is in use: motiondb has {} other sessions; stop its servers", name, sessions);
}

absl::StatusOr<bool> HasRows(Connection& connection) {
  for (const CopiedTable& table : TablesOfStore()) {
    Statement row = connection.Query(fmt::format("SELECT 1 FROM {} LIMIT 1", table.name));
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) return true;
  }
  return false;
}

absl::Status SyncFolder(const std::string& file) {
  const int folder = open(fs::path(file).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return absl::OkStatus();  // cannot be read: the rename is durable later
  const bool synced = fsync(folder) == 0 || errno == EINVAL;
  const int error = errno;
  close(folder);
  if (synced) return absl::OkStatus();
  return absl::UnavailableError(fmt::format("cannot sync '{}': {}", file, std::strerror(error)));
}

}  // namespace

absl::StatusOr<MigrationEnd> MigrationEnd::OpenPostgres(const std::string& store) {
  MOTIONDB_ASSIGN_OR_RETURN(PostgresAddress address, ParsePostgresUrl(store));
  if (address.pooled) {
    return core::InvalidArgument(
        "a migration cannot use a pooler: connect to PostgreSQL itself, without pooled=1");
  }
  MigrationEnd end;
  MOTIONDB_ASSIGN_OR_RETURN(
      auto connection,
      PostgresConnection::Open(std::make_shared<PostgresConnector>(std::move(address))));
  MOTIONDB_RETURN_IF_ERROR(CheckServerVersion(*connection));
  end.name_ = connection->place();
  end.connection_ = std::move(connection);
  return end;
}

absl::StatusOr<MigrationEnd> MigrationEnd::OpenSource(const std::string& store) {
  if (IsPostgresUrl(store)) {
    MOTIONDB_ASSIGN_OR_RETURN(MigrationEnd end, OpenPostgres(store));
    MOTIONDB_RETURN_IF_ERROR(
        InTransaction(*end.connection_, Transaction::Kind::kRead, CheckPostgresVersion));
    MOTIONDB_RETURN_IF_ERROR(CheckIsUnused(*end.connection_, end.name_));
    return end;
  }
  MigrationEnd end;
  MOTIONDB_ASSIGN_OR_RETURN(end.name_, AbsolutePath(store));
  std::error_code error;
  if (!fs::exists(end.name_, error)) return core::NotFound("there is no store '{}'", store);
  MOTIONDB_RETURN_IF_ERROR(CheckIsStore(end.name_));
  // Read-only servers may use it.
  MOTIONDB_ASSIGN_OR_RETURN(end.lock_, StoreLock::Acquire(end.name_, StoreLock::Kind::kShared));
  const OpeningCheck check = CheckBeforeOpening(end.name_, /*read_only=*/true);
  if (!check.found.empty()) {
    return core::DataLoss("{}; first start a server on the store, which saves what can be read",
                          check.found.front().description);
  }
  MOTIONDB_ASSIGN_OR_RETURN(end.connection_, OpenImmutable(end.name_, /*is_short=*/false));
  MOTIONDB_RETURN_IF_ERROR(CheckIsCurrentVersion(*end.connection_));
  return end;
}

absl::StatusOr<MigrationEnd> MigrationEnd::OpenFileTarget(const std::string& store) {
  MigrationEnd end;
  MOTIONDB_ASSIGN_OR_RETURN(end.name_, AbsolutePath(store));
  MOTIONDB_ASSIGN_OR_RETURN(end.lock_, StoreLock::Acquire(end.name_));
  std::error_code error;
  if (fs::exists(end.name_, error)) {
    return core::FailedPrecondition("'{}' exists: migrate into a new file", end.name_);
  }
  end.file_ = end.name_ + kUnfinished;
  MOTIONDB_RETURN_IF_ERROR(CheckIsStore(end.file_));
  MOTIONDB_ASSIGN_OR_RETURN(end.connection_, OpenWriter(end.file_, ""));
  // A power failure may lose the last steps, which are then copied again. Publish syncs.
  MOTIONDB_RETURN_IF_ERROR(end.connection_->Execute("PRAGMA synchronous = NORMAL"));
  return end;
}

absl::StatusOr<MigrationEnd> MigrationEnd::OpenTarget(const std::string& store,
                                                      const MigrationEnd& source) {
  MigrationEnd end;
  if (IsPostgresUrl(store)) {
    MOTIONDB_ASSIGN_OR_RETURN(end, OpenPostgres(store));
    if (end.name_ == source.name_) {
      return core::InvalidArgument("both stores are {}", end.name_);
    }
    MOTIONDB_RETURN_IF_ERROR(MigratePostgres(*end.connection_).status());
    MOTIONDB_RETURN_IF_ERROR(CheckIsUnused(*end.connection_, end.name_));
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(end, OpenFileTarget(store));
  }
  MOTIONDB_RETURN_IF_ERROR(end.Mark(source.name_));
  return end;
}

absl::Status MigrationEnd::Mark(const std::string& source) {
  return InTransaction(
      *connection_, Transaction::Kind::kWrite, [&](Connection& connection) -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(connection.Execute(
            fmt::format("CREATE TABLE IF NOT EXISTS {} (source text NOT NULL)", kMigrationTable)));
        Statement row = connection.Query(fmt::format("SELECT source FROM {}", kMigrationTable));
        MOTIONDB_ASSIGN_OR_RETURN(is_continued_, row.Step());
        if (is_continued_) {
          if (row.Text(0) == source) return absl::OkStatus();
          return core::FailedPrecondition(
              "the store {} has the beginning of a migration from {}, not from {}", name_,
              row.Text(0), source);
        }
        MOTIONDB_ASSIGN_OR_RETURN(const bool has_rows, HasRows(connection));
        // A file has rows but no mark if Publish was interrupted: it is compared again.
        is_continued_ = has_rows;
        if (has_rows && file_.empty()) {
          return core::FailedPrecondition("the store {} is not empty: migrate into an empty one",
                                          name_);
        }
        return connection
            .Query(fmt::format("INSERT INTO {} (source) VALUES (?)", kMigrationTable), source)
            .Run();
      });
}

absl::Status MigrationEnd::Publish() {
  MOTIONDB_RETURN_IF_ERROR(
      InTransaction(*connection_, Transaction::Kind::kWrite, [](Connection& connection) {
        return connection.Execute(fmt::format("DROP TABLE {}", kMigrationTable));
      }));
  if (file_.empty()) {
    connection_.reset();
    return absl::OkStatus();
  }
  MOTIONDB_RETURN_IF_ERROR(connection_->Execute("PRAGMA wal_checkpoint(TRUNCATE)"));
  connection_.reset();  // deletes the log
  std::error_code error;
  if (fs::exists(LogPath(file_), error)) {
    return absl::UnavailableError(fmt::format("cannot close '{}'", file_));
  }
  fs::rename(file_, name_, error);
  if (error) {
    return absl::UnavailableError(
        fmt::format("cannot rename '{}' to '{}': {}", file_, name_, error.message()));
  }
  return SyncFolder(name_);
}

}  // namespace motiondb::storage
