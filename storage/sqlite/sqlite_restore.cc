#include "storage/sqlite/sqlite_restore.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/access_tables.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/row_copy.h"

namespace motiondb::storage {

absl::StatusOr<std::unique_ptr<SqliteRestore>> SqliteRestore::Make(const std::string& store_path,
                                                                   const DiskReserve& reserve,
                                                                   ReplaceContent take_over) {
  MOTIONDB_ASSIGN_OR_RETURN(
      auto received,
      ReceivedStore::Make(store_path, reserve,
                          {.purpose = "restore",
                           .noun = "backup",
                           .program = "motiondb backup",
                           .if_broken = "`motiondbd --store FILE` serves the backup without it"}));
  return std::unique_ptr<SqliteRestore>(
      new SqliteRestore(std::move(received), std::move(take_over)));
}

absl::Status SqliteRestore::Check(const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(checked_, received_->Check(cancelled));
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

absl::StatusOr<std::unique_ptr<SqliteImport>> SqliteImport::Make(const std::string& store_path,
                                                                 const DiskReserve& reserve,
                                                                 StagedDatabases& staged,
                                                                 Transact transact) {
  MOTIONDB_ASSIGN_OR_RETURN(
      auto received, ReceivedStore::Make(
                         store_path, reserve,
                         {.purpose = "import",
                          .noun = "exported database",
                          .program = "motiondb export-database",
                          .if_broken = "delete it from the exported database, then export again"}));
  return std::unique_ptr<SqliteImport>(
      new SqliteImport(std::move(received), staged, std::move(transact)));
}

absl::StatusOr<ExportedDatabase> SqliteImport::Check(const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(auto checked, received_->Check(cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t count,
      checked->QueryInteger("SELECT count(*) FROM database WHERE deleted = 0"));
  if (count != 1) {
    return core::InvalidArgument(
        "the file has {} databases; expected one, as `motiondb export-database` writes it; "
        "`motiondb restore` restores a backup of a whole store",
        count);
  }
  ExportedDatabase content;
  MOTIONDB_ASSIGN_OR_RETURN(auto databases, SelectDatabases(*checked, Page{}));
  content.record = std::move(databases.front());
  MOTIONDB_ASSIGN_OR_RETURN(source_key_, FindDatabase(*checked, content.record.name));
  {
    Statement clips = checked->Query(
        "SELECT count(*), ifnull(sum(frame_count), 0), ifnull(sum(byte_count), 0) FROM clip WHERE "
        "database_key = ? AND deleted = 0",
        source_key_);
    MOTIONDB_RETURN_IF_ERROR(clips.Step().status());
    content.clip_count = clips.Integer<std::int32_t>(0);
    content.frame_count = clips.Integer(1);
    content.byte_count = clips.Integer(2);
  }
  checked_ = std::move(checked);
  return content;
}

absl::Status SqliteImport::Stage(const core::Cancelled& cancelled) {
  if (checked_ == nullptr) return core::FailedPrecondition("the exported database was not checked");
  // Only one attempt: it cannot continue after an error.
  const std::unique_ptr<Connection> source = std::move(checked_);
  RowCopy copy(*source, source_key_, RowCopy::Mode::kImport);
  std::int64_t added_bytes = received_->written_bytes();  // first of the whole, then of each step
  for (bool more = true; more;) {
    if (cancelled && cancelled()) {
      return absl::CancelledError("cancelled while the database was copied");
    }
    bool has_run = false;
    const auto step = [&](Connection& store) -> absl::Status {
      // The copy cannot go back to the rows of a transaction that was rolled back.
      if (std::exchange(has_run, true)) {
        return core::DataLoss(
            "a step of the import was rolled back, because the search index of the store was "
            "corrupt "
            "or of another server: import the file again");
      }
      if (staged_key_ != 0) MOTIONDB_RETURN_IF_ERROR(store.KeepHidden(staged_key_, false));
      MOTIONDB_ASSIGN_OR_RETURN(more, copy.Step(store));
      if (staged_key_ == 0) {
        // In the transaction, before a purge can find the database.
        staged_key_ = copy.target_key();
        staged_.Add(staged_key_);
        return store.KeepHidden(staged_key_, true);
      }
      return absl::OkStatus();
    };
    MOTIONDB_RETURN_IF_ERROR(
        transact_(Priority::kBackground, {nullptr, cancelled}, added_bytes, step));
    added_bytes = RowCopy::kStepBytes;
  }
  is_complete_ = true;
  return absl::OkStatus();
}

absl::Status SqliteImport::Publish(const std::string& database, const WriteOptions& terms) {
  if (!is_complete_) return core::FailedPrecondition("the exported database was not staged");
  const auto show = [&](Connection& store) -> absl::Status {
    MOTIONDB_RETURN_IF_ERROR(ShowDatabase(store, staged_key_, database));
    return store.ReleaseHidden(staged_key_);
  };
  MOTIONDB_RETURN_IF_ERROR(transact_(Priority::kOrdinary, terms, 0, show));
  is_complete_ = false;
  Unstage();
  return absl::OkStatus();
}

void SqliteImport::Unstage() {
  if (staged_key_ != 0) staged_.Remove(std::exchange(staged_key_, 0));
}

}  // namespace motiondb::storage
