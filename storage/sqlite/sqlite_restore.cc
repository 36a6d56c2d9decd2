#include "storage/sqlite/sqlite_restore.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/sql/connection/transaction.h"
#include "storage/sql/tables/audit_table.h"
#include "storage/sql/tables/token_table.h"

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

}  // namespace motiondb::storage
