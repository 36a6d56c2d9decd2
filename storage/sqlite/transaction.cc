#include "storage/sqlite/transaction.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/sqlite/index_corruption.h"

namespace motiondb::storage {

absl::StatusOr<Transaction> Transaction::Begin(Connection& connection, Kind kind) {
  // The object exists before BEGIN: it rolls back even if the statement fails after it began.
  Transaction transaction(connection);
  transaction.RollBack();
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query(kind == Kind::kWrite ? "BEGIN IMMEDIATE" : "BEGIN").Run());
  return transaction;
}

Transaction::Transaction(Transaction&& other) noexcept
    : connection_(std::exchange(other.connection_, nullptr)) {}

Transaction::~Transaction() {
  if (connection_ != nullptr) RollBack();
}

void Transaction::RollBack() {
  // After some errors SQLite has rolled back already. If this fails, the next Begin tries again.
  if (connection_->in_transaction()) connection_->Query("ROLLBACK").Run().IgnoreError();
}

absl::Status Transaction::Commit() {
  // Only the search index reads now: it stores what it has kept in memory.
  return OfSearchIndex(connection_->Query("COMMIT").Run());
}

}  // namespace motiondb::storage
