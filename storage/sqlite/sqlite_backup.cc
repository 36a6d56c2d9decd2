#include "storage/sqlite/sqlite_backup.h"

#include <algorithm>
#include <filesystem>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/row_copy.h"
#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

constexpr int kPagesAtOnce = 256;

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteBackup>> SqliteBackup::Make(Connection& reader,
                                                                 const std::string& store_path,
                                                                 const core::Cancelled& cancelled) {
  std::unique_ptr<SqliteBackup> backup(new SqliteBackup(store_path, "backup"));
  const std::string& path = backup->file_.path();
  {
    MOTIONDB_ASSIGN_OR_RETURN(
        const auto copy,
        SqliteConnection::Open(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
    // The copy need not survive a crash.
    MOTIONDB_RETURN_IF_ERROR(copy->Execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF"));
    // The first read determines the snapshot of the transaction.
    MOTIONDB_RETURN_IF_ERROR(reader.QueryInteger("SELECT count(*) FROM database").status());
    MOTIONDB_RETURN_IF_ERROR(CopyPages(reader, *copy, cancelled));
  }
  MOTIONDB_RETURN_IF_ERROR(backup->OpenCopy());
  return backup;
}

absl::StatusOr<std::unique_ptr<SqliteBackup>> SqliteBackup::MakeExport(
    Connection& reader, const std::string& database, const std::string& store_path,
    const DiskReserve& reserve, const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindDatabase(reader, database));
  std::unique_ptr<SqliteBackup> backup(new SqliteBackup(store_path, "export"));
  MOTIONDB_RETURN_IF_ERROR(backup->CopyRows(reader, key, reserve, cancelled));
  return backup;
}

absl::StatusOr<std::unique_ptr<SqliteBackup>> SqliteBackup::MakeOfRows(
    Connection& reader, const std::string& store_path, const core::Cancelled& cancelled) {
  std::unique_ptr<SqliteBackup> backup(new SqliteBackup(store_path, "backup"));
  MOTIONDB_RETURN_IF_ERROR(
      backup->CopyRows(reader, std::nullopt, DiskReserve(store_path, 0), cancelled));
  return backup;
}

absl::Status SqliteBackup::CopyRows(Connection& reader, std::optional<std::int64_t> database_key,
                                    const DiskReserve& reserve, const core::Cancelled& cancelled) {
  {
    MOTIONDB_ASSIGN_OR_RETURN(const auto copy, OpenWriter(file_.path(), ""));
    // The copy need not survive a crash, and may contain what is corrupt: an import finds it.
    MOTIONDB_RETURN_IF_ERROR(
        copy->Execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; "
                      "PRAGMA foreign_keys = OFF; PRAGMA ignore_check_constraints = ON"));
    RowCopy rows(reader, database_key, RowCopy::Mode::kBackup);
    for (bool more = true; more;) {
      if (cancelled && cancelled()) {
        return absl::CancelledError(database_key ? "cancelled while the database was copied"
                                                 : "cancelled while the store was copied");
      }
      MOTIONDB_RETURN_IF_ERROR(reserve.CheckTemporaryFile(RowCopy::kStepBytes));
      MOTIONDB_ASSIGN_OR_RETURN(
          more, InTransaction(*copy, Transaction::Kind::kWrite,
                              [&](Connection& target) { return rows.Step(target); }));
    }
    MOTIONDB_RETURN_IF_ERROR(InTransaction(
        *copy, Transaction::Kind::kWrite, [&](Connection& target) { return rows.Finish(target); }));
  }
  return OpenCopy();
}

absl::Status SqliteBackup::OpenCopy() {
  std::error_code error;
  file_bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(file_.path(), error));
  stream_.open(file_.path(), std::ios::binary);
  if (error || !stream_) {
    return absl::UnavailableError(
        fmt::format("cannot read the copy of the store, '{}'", file_.path()));
  }
  file_.Remove();  // the open stream can still read it
  return absl::OkStatus();
}

std::int64_t SqliteBackup::total_bytes() const {
  return file_bytes_ + static_cast<std::int64_t>(kBackupTrailerBytes);
}

absl::StatusOr<bool> SqliteBackup::Read(std::string& block) {
  if (ended_) return false;
  const std::int64_t remaining = file_bytes_ - read_bytes_;
  if (remaining == 0) {
    digest_.Update(kBackupMark);
    block = std::string(kBackupMark) + digest_.Finish();
    ended_ = true;
    return true;
  }
  block.resize(static_cast<std::size_t>(std::min<std::int64_t>(remaining, kBackupBlockBytes)));
  stream_.read(block.data(), static_cast<std::streamsize>(block.size()));
  if (!stream_) return absl::UnavailableError("cannot read the copy of the store");
  read_bytes_ += static_cast<std::int64_t>(block.size());
  digest_.Update(block);
  return true;
}

absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled) {
  sqlite3_backup* const copy = sqlite3_backup_init(HandleOf(to), "main", HandleOf(from), "main");
  if (copy == nullptr) return SqliteError(HandleOf(to), sqlite3_extended_errcode(HandleOf(to)));
  int code = SQLITE_OK;
  bool stopped = false;
  while (code == SQLITE_OK && !stopped) {
    stopped = cancelled && cancelled();
    if (!stopped) code = sqlite3_backup_step(copy, kPagesAtOnce);
  }
  // Rolls back unless the last step finished the copy.
  const int finished = sqlite3_backup_finish(copy);
  if (stopped) return absl::CancelledError("cancelled while the store was copied");
  if (code == SQLITE_DONE) code = finished;
  if (code != SQLITE_OK) return SqliteError(HandleOf(to), code);
  return absl::OkStatus();
}

}  // namespace motiondb::storage
