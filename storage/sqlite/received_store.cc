#include "storage/sqlite/received_store.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/sqlite_backup.h"
#include "storage/sqlite/sqlite_verifier.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {

absl::StatusOr<std::unique_ptr<ReceivedStore>> ReceivedStore::Make(const std::string& store_path,
                                                                   const DiskReserve& reserve,
                                                                   Wording wording) {
  std::unique_ptr<ReceivedStore> received(
      new ReceivedStore(store_path, reserve, std::move(wording)));
  const std::string& path = received->file_.path();
  received->stream_.open(path, std::ios::binary | std::ios::trunc);
  if (!received->stream_) {
    return absl::UnavailableError(fmt::format("cannot write '{}': {}", path, std::strerror(errno)));
  }
  MOTIONDB_ASSIGN_OR_RETURN(received->opened_, GetFileIdentity(path));
  return received;
}

absl::Status ReceivedStore::Append(std::string_view bytes) {
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

absl::Status ReceivedStore::Write(std::string_view bytes) {
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

absl::Status ReceivedStore::CheckSum() {
  if (tail_.empty() && !begun_) return core::InvalidArgument("the {} is empty", wording_.noun);
  if (!begun_ && !tail_.starts_with(kSqliteMagic)) return NoBackup();
  if (!tail_.starts_with(kBackupMark) || tail_.size() != kBackupTrailerBytes) {
    return core::InvalidArgument(
        "the checksum at the end is missing: the {} is cut off, or is the file of a store, which "
        "`motiondbd --store` serves",
        wording_.noun);
  }
  digest_.Update(kBackupMark);
  if (std::string_view(tail_).substr(kBackupMark.size()) != digest_.Finish()) {
    return core::InvalidArgument("the {} is corrupt: its checksum does not match", wording_.noun);
  }
  return absl::OkStatus();
}

absl::Status ReceivedStore::CheckIsThere() const {
  absl::Status there = CheckFileIdentity(file_.path(), opened_);
  std::error_code error;
  if (there.ok() && std::filesystem::file_size(file_.path(), error) !=
                        static_cast<std::uintmax_t>(written_bytes_)) {
    there = absl::UnavailableError(fmt::format("'{}' was changed", file_.path()));
  }
  if (there.ok()) return there;
  return absl::UnavailableError(fmt::format("{} while it received the {}; {} the {} again",
                                            std::string(there.message()), wording_.noun,
                                            wording_.purpose, wording_.noun));
}

absl::StatusOr<std::unique_ptr<Connection>> ReceivedStore::Check(const core::Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(CheckSum());
  stream_.close();
  MOTIONDB_RETURN_IF_ERROR(CheckIsThere());
  if (const absl::Status store = CheckIsStore(file_.path()); !store.ok()) return NoBackup();
  // This also migrates the store.
  auto connection = OpenWriterOfExisting(file_.path());
  if (!connection.ok()) return OfFile(connection.status());
  // The file need not survive a crash.
  MOTIONDB_RETURN_IF_ERROR((*connection)->Execute("PRAGMA synchronous = OFF"));
  absl::Status whole = CheckWhole(**connection, cancelled);
  // The search index is derived from the clips: its corruption does not prevent a restore.
  if (absl::IsDataLoss(whole) && RebuildClipText(**connection).ok()) {
    whole = CheckWhole(**connection, cancelled);
  }
  MOTIONDB_RETURN_IF_ERROR(OfFile(whole));
  return connection;
}

// Verifies the whole store. DATA_LOSS with the first corrupt item.
absl::Status ReceivedStore::CheckWhole(Connection& connection,
                                       const core::Cancelled& cancelled) const {
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
      return core::DataLoss("{}: {}; it was corrupt when the {} was made: {}", first.resource,
                            first.description, wording_.noun, wording_.if_broken);
    }
    if (!more) return absl::OkStatus();
  }
}

absl::Status ReceivedStore::NoBackup() const {
  return core::InvalidArgument(
      "not a backup, or its beginning is corrupt; expected a file that `{}` wrote",
      wording_.program);
}

absl::Status ReceivedStore::OfFile(const absl::Status& status) const {
  const absl::Status named = In(fmt::format("the {}", wording_.noun), status);
  return absl::IsDataLoss(named) || absl::IsInternal(named)
             ? absl::InvalidArgumentError(named.message())
             : named;
}

}  // namespace motiondb::storage
