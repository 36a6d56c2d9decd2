#include "storage/sqlite/store_file.h"

#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/clip_row.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/store_lock.h"

namespace motiondb::storage {
namespace {

constexpr char kInMemory[] = ":memory:";

constexpr std::size_t kVersionPlace = 60;  // offset of user_version
constexpr std::size_t kIdPlace = 68;       // offset of the application id

using StoreHeader = std::array<char, kStoreHeaderBytes>;

// Timeout for SQLite's locks, ms. They are held only briefly.
constexpr int kLockWait = 10'000;

// Settings of every connection. The cache holds the pages that lists of 100,000 clips come back to.
constexpr char kCommonSetup[] = R"sql(
PRAGMA mmap_size = 0;
PRAGMA cache_size = -16384;
PRAGMA trusted_schema = OFF;
)sql";

constexpr char kWriterSetup[] = R"sql(
PRAGMA foreign_keys = ON;
PRAGMA synchronous = FULL;
PRAGMA journal_size_limit = 67108864;
)sql";

constexpr char kReaderSetup[] = R"sql(
PRAGMA query_only = ON;
PRAGMA wal_autocheckpoint = 0;
)sql";

absl::Status NotAStore(std::string_view path, std::string_view what) {
  return core::FailedPrecondition("'{}' is not a motiondb store but {}; it was not changed", path,
                                  what);
}

std::string_view AsText(const StoreHeader& header) { return {header.data(), header.size()}; }

// Reads the header of a file; fills up a shorter file with zeros.
absl::StatusOr<StoreHeader> ReadHeader(const std::string& path) {
  StoreHeader header{};
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  stream.read(header.data(), header.size());
  if (stream.bad() || !stream.is_open()) {
    return absl::UnavailableError(
        fmt::format("cannot read '{}': {}", path, std::strerror(errno == 0 ? EIO : errno)));
  }
  return header;
}

// Sets page size and application id of an empty file; checks the id of any other file.
absl::Status Initialize(Connection& connection, const std::string& path) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto pages, connection.QueryInteger("PRAGMA page_count"));
  if (pages == 0) {
    // Before the log is enabled: the id is then in the file itself, even if the opening fails.
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
      "'{}' cannot use a write-ahead log (journal mode '{}'); put the store on a local disk", path,
      mode.Text(0));
}

// Returns an SQLite URI of `path` with the option that the file does not change.
std::string ImmutableUri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : path) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '/' || c == '.';
    uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri + "?immutable=1";
}

absl::Status SetUp(Connection& connection) {
  sqlite3_busy_timeout(HandleOf(connection), kLockWait);
  return connection.Execute(kCommonSetup);
}

// Opens a write connection to a file of any version.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriterWith(int flags, const std::string& path,
                                                           const std::string& vfs) {
  MOTIONDB_ASSIGN_OR_RETURN(auto connection,
                            SqliteConnection::Open(path, SQLITE_OPEN_READWRITE | flags, vfs));
  MOTIONDB_RETURN_IF_ERROR(SetUp(*connection));
  MOTIONDB_RETURN_IF_ERROR(Initialize(*connection, path));
  if (path != kInMemory) MOTIONDB_RETURN_IF_ERROR(UseLog(*connection, path));
  MOTIONDB_RETURN_IF_ERROR(connection->Execute(kWriterSetup));
  return connection;
}

// Migrates a store to the current version.
absl::Status Upgrade(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto version, connection.QueryInteger("PRAGMA user_version"));
  // Version 10 normalised the words of the search index otherwise. If the upgrade is interrupted,
  // the index is made again; a program of version 10 would meanwhile not find all words. Of corrupt
  // clips none can be made, which must not prevent opening.
  if (version == 10) {
    const absl::Status rebuilt = RebuildClipText(connection);
    if (!rebuilt.ok() && !absl::IsDataLoss(rebuilt)) return rebuilt;
  }
  return Migrate(connection, Migrations());
}

}  // namespace

bool IsStoreHeader(std::string_view header) {
  return header.starts_with(kSqliteMagic) && BigEndian(header, kIdPlace) == kApplicationId;
}

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

  // Not with SQLite: it reports corruption if the file is shorter than its page count. A full disk
  // or a power cut during a checkpoint leaves such a file, which its log completes.
  MOTIONDB_ASSIGN_OR_RETURN(const StoreHeader header, ReadHeader(path));
  if (!AsText(header).starts_with(kSqliteMagic)) {
    return NotAStore(path, "a file of another kind");
  }
  if (!IsStoreHeader(AsText(header))) return NotAStore(path, "another SQLite file");
  return absl::OkStatus();
}

absl::StatusOr<int> ReadStoreVersion(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const std::string file = fs::canonical(path, error).string();
  if (error || fs::file_size(file, error) == 0) return 0;
  MOTIONDB_RETURN_IF_ERROR(CheckIsStore(file));
  MOTIONDB_ASSIGN_OR_RETURN(const StoreHeader header, ReadHeader(file));
  const auto version = static_cast<int>(BigEndian(AsText(header), kVersionPlace));
  if (version >= static_cast<int>(Migrations().size())) return version;
  // The log may contain a later version: an upgrade that was not checkpointed before a crash.
  MOTIONDB_ASSIGN_OR_RETURN(const StoreLock lock, StoreLock::Acquire(file));
  MOTIONDB_ASSIGN_OR_RETURN(const auto reader, OpenReader(file, ""));
  MOTIONDB_ASSIGN_OR_RETURN(const auto logged, reader->QueryInteger("PRAGMA user_version"));
  return static_cast<int>(logged);
}

absl::StatusOr<std::unique_ptr<Connection>> OpenWriter(const std::string& path,
                                                       const std::string& vfs) {
  MOTIONDB_ASSIGN_OR_RETURN(auto connection, OpenWriterWith(SQLITE_OPEN_CREATE, path, vfs));
  const absl::Status migrated = Upgrade(*connection);
  if (!migrated.ok()) {
    return absl::Status(migrated.code(),
                        fmt::format("'{}': {}", path, std::string(migrated.message())));
  }
  FillMissingByteCounts(*connection);
  return connection;
}

absl::StatusOr<std::unique_ptr<Connection>> OpenWriterOfExisting(const std::string& path) {
  MOTIONDB_ASSIGN_OR_RETURN(auto connection, OpenWriterWith(0, path, ""));
  MOTIONDB_RETURN_IF_ERROR(Upgrade(*connection));
  FillMissingByteCounts(*connection);
  return connection;
}

absl::StatusOr<std::unique_ptr<Connection>> OpenReader(const std::string& path,
                                                       const std::string& vfs) {
  MOTIONDB_ASSIGN_OR_RETURN(auto connection,
                            SqliteConnection::Open(path, SQLITE_OPEN_READONLY, vfs));
  sqlite3_db_config(HandleOf(*connection), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  MOTIONDB_RETURN_IF_ERROR(SetUp(*connection));
  MOTIONDB_RETURN_IF_ERROR(connection->Execute(kReaderSetup));
  return connection;
}

absl::StatusOr<std::unique_ptr<Connection>> OpenImmutable(const std::string& path, bool is_short) {
  absl::StatusOr<std::unique_ptr<Connection>> opened;
  std::error_code error;
  if (std::filesystem::exists(LogPath(path), error)) {
    // With exclusive access and without locks, SQLite keeps the index of the log in memory.
    MOTIONDB_ASSIGN_OR_RETURN(opened,
                              SqliteConnection::Open(path, SQLITE_OPEN_READONLY, "unix-none"));
    MOTIONDB_RETURN_IF_ERROR((*opened)->Execute("PRAGMA locking_mode = EXCLUSIVE"));
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(
        opened,
        SqliteConnection::Open(ImmutableUri(path), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, ""));
  }
  Connection& connection = **opened;
  // With this setting SQLite accepts a page count that is larger than the file. It must precede the
  // settings that read the schema.
  if (is_short) MOTIONDB_RETURN_IF_ERROR(connection.Execute("PRAGMA writable_schema = ON"));
  sqlite3_db_config(HandleOf(connection), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  MOTIONDB_RETURN_IF_ERROR(SetUp(connection));
  MOTIONDB_RETURN_IF_ERROR(connection.Execute(kReaderSetup));
  return opened;
}

absl::Status CheckIsCurrentVersion(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto version, connection.QueryInteger("PRAGMA user_version"));
  const auto latest = static_cast<std::int64_t>(Migrations().size());
  if (version == latest) return absl::OkStatus();
  return core::FailedPrecondition(
      "the store is of version {}; expected {}: open it once without --read-only to upgrade an "
      "older version",
      version, latest);
}

void CheckpointLog(Connection& writer) {
  sqlite3_busy_timeout(HandleOf(writer), 0);
  // If a reader blocks or the disk is full, the log keeps its size.
  writer.Execute("PRAGMA wal_checkpoint(TRUNCATE)").IgnoreError();
  sqlite3_busy_timeout(HandleOf(writer), kLockWait);
}

}  // namespace motiondb::storage
