#include "storage/sqlite/sqlite_restore.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/sqlite/audit_table.h"
#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/sqlite_backup.h"
#include "storage/sqlite/sqlite_verifier.h"
#include "storage/sqlite/store_file.h"
#include "storage/sqlite/token_table.h"
#include "storage/sqlite/transaction.h"

namespace motiondb::storage {
namespace {

constexpr char kIn[] = "the backup";

absl::Status NoBackup() {
  return core::InvalidArgument(
      "not a backup, or its beginning is corrupt; expected a file that `motiondb backup` wrote");
}

// Names the backup in an error. DATA_LOSS and INTERNAL of a backup become INVALID_ARGUMENT: the
// input is wrong, this store is not corrupt.
absl::Status OfBackup(const absl::Status& status) {
  const absl::Status named = In(kIn, status);
  return absl::IsDataLoss(named) || absl::IsInternal(named)
             ? absl::InvalidArgumentError(named.message())
             : named;
}

// Verifies a whole store. DATA_LOSS with the first corrupt item.
absl::Status CheckWhole(Connection& connection, const core::Cancelled& cancelled) {
  SqliteVerifier verifier(
      [&](const SqliteVerifier::Look& look) -> absl::Status {
        MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                                  Transaction::Begin(connection, Transaction::Kind::kRead));
        return look(connection);
      },
      {}, cancelled);
  std::vector<Corruption> found;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool more, verifier.Step(found));
    if (!found.empty()) {
      const Corruption& first = found.front();
      if (first.resource.empty()) return core::DataLoss("{}", first.description);
      return core::DataLoss(
          "{}: {}; it was corrupt when the backup was made: `motiondbd --store FILE` serves the "
          "backup without it",
          first.resource, first.description);
    }
    if (!more) return absl::OkStatus();
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteRestore>> SqliteRestore::Make(const std::string& store_path,
                                                                   const DiskReserve& reserve,
                                                                   ReplaceContent take_over) {
  std::unique_ptr<SqliteRestore> restore(
      new SqliteRestore(store_path, reserve, std::move(take_over)));
  restore->stream_.open(restore->file_.path(), std::ios::binary | std::ios::trunc);
  if (!restore->stream_) {
    return absl::UnavailableError(
        fmt::format("cannot write '{}': {}", restore->file_.path(), std::strerror(errno)));
  }
  MOTIONDB_ASSIGN_OR_RETURN(restore->opened_, GetFileIdentity(restore->file_.path()));
  return restore;
}

absl::Status SqliteRestore::Append(std::string_view bytes) {
  tail_ += bytes;
  if (!begun_ && tail_.size() >= kStoreHeaderBytes) {
    // Refuse a wrong file before the client has sent all of it.
    if (!IsStoreHeader(tail_)) return NoBackup();
    begun_ = true;
  }
  if (!begun_ || tail_.size() <= kBackupTrailerBytes) return absl::OkStatus();
  const std::size_t ready = tail_.size() - kBackupTrailerBytes;
  MOTIONDB_RETURN_IF_ERROR(Write(std::string_view(tail_).substr(0, ready)));
  tail_.erase(0, ready);
  return absl::OkStatus();
}

absl::Status SqliteRestore::Write(std::string_view bytes) {
  MOTIONDB_RETURN_IF_ERROR(reserve_.CheckTemporaryFile(static_cast<std::int64_t>(bytes.size())));
  digest_.Update(bytes);
  errno = 0;
  stream_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream_.flush();
  written_bytes_ += static_cast<std::int64_t>(bytes.size());
  if (stream_) return absl::OkStatus();
  const std::string message =
      fmt::format("cannot write '{}': {}", file_.path(), std::strerror(errno == 0 ? EIO : errno));
  return errno == ENOSPC || errno == EDQUOT ? absl::ResourceExhaustedError(message)
                                            : absl::UnavailableError(message);
}

absl::Status SqliteRestore::CheckSum() {
  if (tail_.empty() && !begun_) return core::InvalidArgument("the backup is empty");
  if (!begun_ && !tail_.starts_with(kSqliteMagic)) return NoBackup();
  if (!tail_.starts_with(kBackupMark) || tail_.size() != kBackupTrailerBytes) {
    return core::InvalidArgument(
        "the checksum at the end is missing: the backup is cut off, or is the file of a store, "
        "which `motiondbd --store` serves");
  }
  digest_.Update(kBackupMark);
  if (std::string_view(tail_).substr(kBackupMark.size()) != digest_.Finish()) {
    return core::InvalidArgument("the backup is corrupt: its checksum does not match");
  }
  return absl::OkStatus();
}

absl::Status SqliteRestore::CheckIsThere() const {
  absl::Status there = CheckFileIdentity(file_.path(), opened_);
  std::error_code error;
  if (there.ok() && std::filesystem::file_size(file_.path(), error) !=
                        static_cast<std::uintmax_t>(written_bytes_)) {
    there = absl::UnavailableError(fmt::format("'{}' was changed", file_.path()));
  }
  if (there.ok()) return there;
  return absl::UnavailableError(fmt::format(
      "{} while it received the backup; restore the backup again", std::string(there.message())));
}

absl::Status SqliteRestore::Check(const core::Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckSum());
  stream_.close();
  MOTIONDB_RETURN_IF_ERROR(CheckIsThere());
  if (const absl::Status store = CheckIsStore(file_.path()); !store.ok()) return NoBackup();
  // This also migrates the backup.
  auto backup = OpenWriterOfExisting(file_.path());
  if (!backup.ok()) return OfBackup(backup.status());
  // The file need not survive a crash.
  MOTIONDB_RETURN_IF_ERROR((*backup)->Execute("PRAGMA synchronous = OFF"));
  MOTIONDB_RETURN_IF_ERROR(OfBackup(CheckWhole(**backup, cancelled)));
  checked_ = *std::move(backup);
  return absl::OkStatus();
}

absl::Status SqliteRestore::Finish(const core::Cancelled& cancelled) {
  if (checked_ == nullptr) return core::FailedPrecondition("the backup was not checked");
  // Only one attempt: `take_over_` changes the backup first.
  const std::unique_ptr<Connection> backup = std::move(checked_);
  return take_over_(*backup, cancelled);
}

absl::Status CopyAccessRecords(Connection& target, Connection& backup) {
  MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                            Transaction::Begin(backup, Transaction::Kind::kWrite));
  constexpr int kLimit = 1000;
  std::string after;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto tokens, SelectTokens(target, after, kLimit));
    if (tokens.empty()) break;
    for (const TokenRecord& token : tokens) {
      MOTIONDB_RETURN_IF_ERROR(backup.Query("DELETE FROM token WHERE id = ?", token.id).Run());
      MOTIONDB_RETURN_IF_ERROR(InsertToken(backup, token));
    }
    after = tokens.back().id;
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto newest_first, SelectAuditRecords(target, 0, kAuditLimit));
  for (auto record = newest_first.rbegin(); record != newest_first.rend(); ++record) {
    MOTIONDB_RETURN_IF_ERROR(InsertAuditRecord(backup, *record));
  }
  return transaction.Commit();
}

}  // namespace motiondb::storage
