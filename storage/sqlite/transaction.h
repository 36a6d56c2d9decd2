// A transaction that ends with its scope: undone unless committed. Not thread-safe.
#pragma once

#include <type_traits>

#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

class Transaction {
 public:
  enum class Kind {
    kRead,   // all that is read is of one moment
    kWrite,  // excludes other writers from the start
  };

  // The connection must outlive the transaction, and no statement may outlive that.
  static absl::StatusOr<Transaction> Begin(Connection& connection, Kind kind);
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();

  // Returns when what was written is durable. After an error nothing was written.
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

// Runs work(Connection&), which returns a Status or StatusOr, in a transaction, which is undone
// where that is an error.
template <typename Work>
auto InTransaction(Connection& connection, Transaction::Kind kind, const Work& work)
    -> std::invoke_result_t<Work, Connection&> {
  MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(connection, kind));
  auto result = work(connection);
  if (!StatusOf(result).ok()) return result;
  MOTIONDB_RETURN_IF_ERROR(transaction.Commit());
  return result;
}

}  // namespace motiondb::storage
