#include "storage/sqlite/transaction.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::storage {

absl::StatusOr<Transaction> Transaction::Begin(Connection& connection, Kind kind) {
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query(kind == Kind::kWrite ? "BEGIN IMMEDIATE" : "BEGIN").Run());
  return Transaction(connection);
}

Transaction::Transaction(Transaction&& other) noexcept
    : connection_(std::exchange(other.connection_, nullptr)) {}

Transaction::~Transaction() {
  // SQLite has undone it already after some errors. Where this fails, the next Begin does too.
  if (connection_ != nullptr && connection_->in_transaction()) {
    connection_->Query("ROLLBACK").Run().IgnoreError();
  }
}

absl::Status Transaction::Commit() { return connection_->Query("COMMIT").Run(); }

}  // namespace motiondb::storage
