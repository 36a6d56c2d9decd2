// A transaction. The destructor rolls it back unless it was committed.
#pragma once

#include <type_traits>

#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

class Transaction {
 public:
  using Kind = Connection::TransactionKind;

  // The connection must outlive the transaction; the transaction must outlive its statements.
  static absl::StatusOr<Transaction> Begin(Connection& connection, Kind kind);
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();

  // Returns when the changes are durable. After an error nothing was changed, unless the connection
  // says that it does not know.
  absl::Status Commit();

 private:
  explicit Transaction(Connection& connection) : connection_(&connection) {}
  void RollBack();

  Connection* connection_;  // null once moved from
};

inline const absl::Status& StatusOf(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

// Runs work(Connection&), which returns a Status or StatusOr, in a transaction, which is rolled
// back on an error. May run it again if it failed because of a concurrent transaction.
template <typename Work>
auto InTransaction(Connection& connection, Transaction::Kind kind, const Work& work)
    -> std::invoke_result_t<Work, Connection&> {
  using Result = std::invoke_result_t<Work, Connection&>;
  const auto run = [&]() -> Result {
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(connection, kind));
    Result result = work(connection);
    if (!StatusOf(result).ok()) return result;
    MOTIONDB_RETURN_IF_ERROR(transaction.Commit());
    return result;
  };
  for (int attempts = 1;; ++attempts) {
    Result result = run();
    if (StatusOf(result).ok() || !connection.MayRunAgain(StatusOf(result), attempts)) return result;
  }
}

}  // namespace motiondb::storage
