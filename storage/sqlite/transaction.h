// A transaction that ends with its scope: undone unless committed. Not thread-safe.
#pragma once

#include "absl/status/statusor.h"
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

}  // namespace motiondb::storage
