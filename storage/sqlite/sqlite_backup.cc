#include "storage/sqlite/sqlite_backup.h"

#include <algorithm>
#include <filesystem>

#include "core/motion/error.h"

namespace motiondb::storage {

absl::StatusOr<std::unique_ptr<SqliteBackup>> SqliteBackup::Make(Connection& reader,
                                                                 const std::string& store_path,
                                                                 const core::Cancelled& cancelled) {
  std::unique_ptr<SqliteBackup> backup(new SqliteBackup(store_path));
  const std::string& path = backup->file_.path();
  {
    MOTIONDB_ASSIGN_OR_RETURN(
        const auto copy, Connection::Open(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, ""));
    // The copy need not survive a crash.
    MOTIONDB_RETURN_IF_ERROR(copy->Execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF"));
    // The first read determines the snapshot of the transaction.
    MOTIONDB_RETURN_IF_ERROR(reader.QueryInteger("SELECT count(*) FROM database").status());
    MOTIONDB_RETURN_IF_ERROR(CopyPages(reader, *copy, cancelled));
  }
  std::error_code error;
  backup->file_bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  backup->stream_.open(path, std::ios::binary);
  if (error || !backup->stream_) {
    return absl::UnavailableError(fmt::format("cannot read the copy of the store, '{}'", path));
  }
  backup->file_.Remove();  // the open stream can still read it
  return backup;
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

}  // namespace motiondb::storage
