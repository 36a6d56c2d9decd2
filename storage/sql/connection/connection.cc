#include "storage/sql/connection/connection.h"

#include <utility>

namespace motiondb::storage {

Statement::~Statement() {
  if (prepared_ == nullptr) return;
  prepared_->Reset();
  connection_->GiveBack(std::move(prepared_));
}

void Statement::BindColumn(const Statement& row, int column) {
  switch (row.Type(column)) {
    case ColumnType::kNull:
      return Bind(nullptr);
    case ColumnType::kInteger:
      return Bind(row.Integer(column));
    case ColumnType::kReal:
      return Bind(row.Real(column));
    case ColumnType::kText:
      return Bind(row.Text(column));
    case ColumnType::kBlob:
      return Bind(row.Blob(column));
  }
}

absl::Status Statement::Run() {
  while (true) {
    const auto row = Step();
    if (!row.ok()) return row.status();
    if (!*row) return absl::OkStatus();
  }
}

absl::Status Statement::RunLater() {
  MOTIONDB_ASSIGN_OR_RETURN(const bool is_queued, prepared_->Queue());
  return is_queued ? absl::OkStatus() : Run();
}

absl::StatusOr<std::int64_t> Connection::QueryInteger(std::string_view sql) {
  Statement statement = Query(sql);
  MOTIONDB_ASSIGN_OR_RETURN(const bool row, statement.Step());
  if (!row) return core::NotFound("expected a row, got none from '{}'", sql);
  return statement.Integer(0);
}

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
