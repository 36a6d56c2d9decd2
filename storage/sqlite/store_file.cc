#include "storage/sqlite/store_file.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "core/motion/error.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/transaction.h"

namespace motiondb::storage {
namespace {

constexpr char kInMemory[] = ":memory:";

// A SQLite file's header.
constexpr std::size_t kHeaderBytes = 100;
constexpr std::size_t kIdPlace = 68;  // of the application id

// For every connection. A wait of ten seconds is long for a lock that is held for moments.
constexpr char kCommonSetup[] = R"sql(
PRAGMA busy_timeout = 10000;
PRAGMA mmap_size = 0;
PRAGMA trusted_schema = OFF;
)sql";

constexpr char kWriterSetup[] = R"sql(
PRAGMA foreign_keys = ON;
PRAGMA synchronous = FULL;
PRAGMA cache_size = -16384;
PRAGMA journal_size_limit = 67108864;
)sql";

constexpr char kReaderSetup[] = R"sql(
PRAGMA query_only = ON;
PRAGMA wal_autocheckpoint = 0;
)sql";

absl::Status NotAStore(std::string_view path, std::string_view what) {
  return core::FailedPrecondition("'{}' is not a motiondb store but {}; it was left as it was",
                                  path, what);
}

// Gives an empty file its page size and its application id; a file that has an id keeps it.
absl::Status Initialize(Connection& connection, const std::string& path) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto pages, connection.QueryInteger("PRAGMA page_count"));
  if (pages == 0) {
    // Before the log is on: an id that is in the file itself is there to see however this ends.
    MOTIONDB_RETURN_IF_ERROR(connection.Execute("PRAGMA page_size = 16384"));
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                              Transaction::Begin(connection, Transaction::Kind::kWrite));
    MOTIONDB_RETURN_IF_ERROR(
        connection.Execute(fmt::format("PRAGMA application_id = {}", kApplicationId)));
    MOTIONDB_RETURN_IF_ERROR(transaction.Commit());
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto id, connection.QueryInteger("PRAGMA application_id"));
  if (id != kApplicationId) return NotAStore(path, "another SQLite file");
  return absl::OkStatus();
}

absl::Status UseLog(Connection& connection, const std::string& path) {
  Statement mode = connection.Query("PRAGMA journal_mode = WAL");
  MOTIONDB_RETURN_IF_ERROR(mode.Step().status());
  if (mode.Text(0) == "wal") return absl::OkStatus();
  return core::FailedPrecondition(
      "'{}' cannot have a write-ahead log (journal mode '{}'): is it on a network file system?",
      path, mode.Text(0));
}

absl::StatusOr<std::unique_ptr<Connection>> OpenWriterWith(int flags, const std::string& path,
                                                           const std::string& vfs) {
  MOTIONDB_ASSIGN_OR_RETURN(auto connection,
                            Connection::Open(path, SQLITE_OPEN_READWRITE | flags, vfs));
  MOTIONDB_RETURN_IF_ERROR(connection->Execute(kCommonSetup));
  MOTIONDB_RETURN_IF_ERROR(Initialize(*connection, path));
  if (path != kInMemory) MOTIONDB_RETURN_IF_ERROR(UseLog(*connection, path));
  MOTIONDB_RETURN_IF_ERROR(connection->Execute(kWriterSetup));
  const absl::Status migrated = Migrate(*connection, Migrations());
  if (!migrated.ok()) {
    return absl::Status(migrated.code(),
                        fmt::format("'{}': {}", path, std::string(migrated.message())));
  }
  return connection;
}

}  // namespace

absl::Status CheckIsStore(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status file = fs::status(path, error);
  if (file.type() == fs::file_type::not_found) return absl::OkStatus();
  if (error) {
    return absl::UnavailableError(fmt::format("cannot open '{}': {}", path, error.message()));
  }
  if (file.type() != fs::file_type::regular) return NotAStore(path, "something other than a file");
  if (fs::file_size(path, error) == 0) return absl::OkStatus();

  // Not by SQLite, which finds a file damaged that is shorter than its first page says, as one is
  // whose log was not moved into it to the end: a full disk or a power cut leaves it so.
  std::array<char, kHeaderBytes> header{};
  std::ifstream stream(path, std::ios::binary);
  stream.read(header.data(), header.size());
  if (stream.bad() || !stream.is_open()) {
    return absl::UnavailableError(fmt::format("cannot read '{}'", path));
  }
  if (!std::string_view(header.data(), header.size()).starts_with(kSqliteMagic)) {
    return NotAStore(path, "a file of another kind");
  }
  std::uint32_t id = 0;  // big-endian
  for (int i = 0; i < 4; ++i) id = id << 8 | static_cast<unsigned char>(header[kIdPlace + i]);
  if (id != kApplicationId) return NotAStore(path, "another SQLite file");
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<Connection>> OpenWriter(const std::string& path,
                                                       const std::string& vfs) {
  return OpenWriterWith(SQLITE_OPEN_CREATE, path, vfs);
}

absl::StatusOr<std::unique_ptr<Connection>> OpenWriterOfExisting(const std::string& path) {
  return OpenWriterWith(0, path, "");
}

absl::StatusOr<std::unique_ptr<Connection>> OpenReader(const std::string& path,
                                                       const std::string& vfs) {
  MOTIONDB_ASSIGN_OR_RETURN(auto connection, Connection::Open(path, SQLITE_OPEN_READONLY, vfs));
  sqlite3_db_config(connection->handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  MOTIONDB_RETURN_IF_ERROR(connection->Execute(kCommonSetup));
  MOTIONDB_RETURN_IF_ERROR(connection->Execute(kReaderSetup));
  return connection;
}

}  // namespace motiondb::storage
