// The maintenance interface of SqliteMotionStore, and the checks whether it can be written.
#include <chrono>
#include <utility>

#include "core/motion/error.h"
#include "storage/sql/sql_motion_store_work.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/sqlite_backup.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "storage/sqlite/sqlite_restore.h"
#include "storage/sqlite/sqlite_verifier.h"
#include "storage/sqlite/store_disk.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

absl::StatusOr<std::int64_t> StoreBytes(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto pages, connection.QueryInteger("PRAGMA page_count"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto page_bytes, connection.QueryInteger("PRAGMA page_size"));
  return pages * page_bytes;
}

}  // namespace

absl::Status SqliteMotionStore::CheckFile() {
  if (path_.empty() || read_only_) return absl::OkStatus();
  const absl::Status store = CheckFileIdentity(path_, files_.store);
  if (!store.ok()) {
    return absl::UnavailableError(
        fmt::format("the store's file {}: changes are refused because they would be lost; put the "
                    "file back, or stop the server and restore a backup",
                    std::string(store.message())));
  }
  const absl::Status log = CheckFileIdentity(LogPath(path_), files_.log);
  if (!log.ok()) {
    return absl::UnavailableError(fmt::format(
        "the store's log {}: changes are refused because they would be lost; put the file back, or "
        "restart the server with SIGTERM, which saves the content of the log",
        std::string(log.message())));
  }
  return absl::OkStatus();
}

absl::Status SqliteMotionStore::CheckIsWritable() const {
  if (!read_only_) return absl::OkStatus();
  return core::FailedPrecondition(
      "the store is open read-only: restart motiondbd without --read-only to change it");
}

absl::Status SqliteMotionStore::CheckMayWrite(Connection& writer, Added added) {
  absl::Status file = CheckFile();
  if (!file.ok()) {
    CheckpointLog(writer);
    return file;
  }
  if (added) {
    MOTIONDB_RETURN_IF_ERROR(reserve_.Check(writer, *added));
  } else {
    reserve_.GiveBack(writer);
  }
  if (index_is_corrupt_.exchange(false)) {
    const absl::Status rebuilt = RebuildClipText(writer);
    if (on_index_rebuild_) on_index_rebuild_(rebuilt);
  }
  return absl::OkStatus();
}

absl::Status SqliteMotionStore::CheckWrites() {
  MOTIONDB_RETURN_IF_ERROR(CheckFile());
  if (!write_health().is_suspect() && reserve_.HasReserve()) return absl::OkStatus();
  return write_health().Try([this] { return TryWriting(); });
}

absl::Status SqliteMotionStore::TryWriting() {
  // Size of a small clip in the log and in the file.
  constexpr std::int64_t kAddedBytes = 256 << 10;
  constexpr std::chrono::seconds kMaxWait{1};
  const auto latest = WaitClock::now() + kMaxWait;
  const auto write = [this](Connection& writer) -> absl::Status {
    MOTIONDB_RETURN_IF_ERROR(reserve_.Check(writer, kAddedBytes));
    MOTIONDB_ASSIGN_OR_RETURN(const auto version, writer.QueryInteger("PRAGMA user_version"));
    return InTransaction(writer, Transaction::Kind::kWrite, [&](Connection& connection) {
      return connection.Execute(fmt::format("PRAGMA user_version = {}", version));
    });
  };
  return writer()->Run(
      Priority::kUrgent, [&] { return WaitClock::now() > latest; }, write);
}

absl::StatusOr<std::unique_ptr<StoreVerifier>> SqliteMotionStore::BeginVerify(
    core::Cancelled cancelled) {
  return std::make_unique<SqliteVerifier>(
      [this](const SqliteVerifier::Look& look) { return Read(look); }, found_at_opening_,
      std::move(cancelled), [this] { index_is_corrupt_ = true; });
}

absl::StatusOr<std::unique_ptr<StoreBackup>> SqliteMotionStore::BeginBackup(
    const core::Cancelled& cancelled) {
  if (path_.empty()) return core::FailedPrecondition("cannot back up a store in memory");
  return Read([&](Connection& reader) -> absl::StatusOr<std::unique_ptr<StoreBackup>> {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t bytes, StoreBytes(reader));
    MOTIONDB_RETURN_IF_ERROR(reserve_.CheckTemporaryFile(bytes));
    return SqliteBackup::Make(reader, path_, cancelled);
  });
}

absl::StatusOr<std::unique_ptr<StoreRestore>> SqliteMotionStore::BeginRestore() {
  if (path_.empty()) return core::FailedPrecondition("cannot restore into a store in memory");
  MOTIONDB_RETURN_IF_ERROR(CheckIsWritable());
  MOTIONDB_RETURN_IF_ERROR(Read([](Connection& reader) { return CheckHasNoDatabases(reader); }));
  return SqliteRestore::Make(path_, reserve_,
                             [this](Connection& backup, const core::Cancelled& cancelled) {
                               return ReplaceContent(backup, cancelled);
                             });
}

absl::StatusOr<std::unique_ptr<StoreBackup>> SqliteMotionStore::BeginExport(
    const std::string& database, const core::Cancelled& cancelled) {
  if (path_.empty()) return core::FailedPrecondition("cannot export from a store in memory");
  return Read([&](Connection& reader) -> absl::StatusOr<std::unique_ptr<StoreBackup>> {
    return SqliteBackup::MakeExport(reader, database, path_, reserve_, cancelled);
  });
}

absl::StatusOr<std::unique_ptr<DatabaseImport>> SqliteMotionStore::BeginImport() {
  if (path_.empty()) return core::FailedPrecondition("cannot import into a store in memory");
  MOTIONDB_RETURN_IF_ERROR(CheckIsWritable());
  return SqliteImport::Make(path_, reserve_, staged(),
                            [this](Priority priority, const WriteOptions& terms,
                                   std::int64_t added_bytes, const SqliteImport::Piece& piece) {
                              return WriteWith(terms, piece, Added(added_bytes), priority);
                            });
}

absl::Status SqliteMotionStore::ReplaceContent(Connection& backup,
                                               const core::Cancelled& cancelled) {
  return writer()->Run(Priority::kOrdinary, cancelled, [&](Connection& writer) -> absl::Status {
    MOTIONDB_RETURN_IF_ERROR(CheckMayWrite(writer, {}));
    MOTIONDB_RETURN_IF_ERROR(CheckHasNoDatabases(writer));
    if (!staged().IsEmpty()) {
      return core::FailedPrecondition(
          "a database is being imported: restore a backup into an empty store");
    }
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t bytes, StoreBytes(backup));
    MOTIONDB_RETURN_IF_ERROR(reserve_.Check(writer, bytes));
    MOTIONDB_RETURN_IF_ERROR(CopyAccessRecords(writer, backup));
    MOTIONDB_RETURN_IF_ERROR(CopyPages(backup, writer, cancelled));
    // The log now contains the whole store; if readers block the checkpoint, a later write does it.
    writer.Execute("PRAGMA wal_checkpoint(PASSIVE)").IgnoreError();
    return absl::OkStatus();
  });
}

}  // namespace motiondb::storage
