#include "storage/sql/connection/transaction.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::storage {

absl::StatusOr<Transaction> Transaction::Begin(Connection& connection, Kind kind) {
  // The object exists before BEGIN: it rolls back even if the statement fails after it began.
  Transaction transaction(connection);
  transaction.RollBack();
  MOTIONDB_RETURN_IF_ERROR(connection.BeginTransaction(kind));
  return transaction;
}

Transaction::Transaction(Transaction&& other) noexcept
    : connection_(std::exchange(other.connection_, nullptr)) {}

Transaction::~Transaction() {
  if (connection_ != nullptr) RollBack();
}

void Transaction::RollBack() { connection_->RollBackTransaction(); }

absl::Status Transaction::Commit() { return connection_->CommitTransaction(); }

}  // namespace motiondb::storage
