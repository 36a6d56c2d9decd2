// A prepared statement of SQLite, and its errors as statuses.
#pragma once

#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/sql/connection/statement.h"

namespace motiondb::storage {

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

// A statement that failed to be prepared has no handle, and its first Step returns the error.
class SqliteStatement final : public PreparedStatement {
 public:
  // `handle` is null if `status` is an error. The database must outlive the object.
  SqliteStatement(sqlite3* database, StatementHandle handle, absl::Status status)
      : database_(database), handle_(std::move(handle)), status_(std::move(status)) {}

  void BindInteger(std::int64_t value) override;
  void BindReal(double value) override;
  void BindText(std::string_view text) override;  // copied
  void BindBlob(std::span<const std::byte> blob) override;
  void BindNull() override;

  absl::StatusOr<bool> Step() override;
  void Reset() override;

  // Tables are STRICT: the types are the declared ones.
  std::int64_t Integer(int column) const override {
    return sqlite3_column_int64(handle_.get(), column);
  }
  double Real(int column) const override { return sqlite3_column_double(handle_.get(), column); }
  std::string Text(int column) const override;
  std::span<const std::byte> Blob(int column) const override;
  ColumnType Type(int column) const override;

  // Returns its text; null if it could not be prepared.
  const char* sql() const { return sqlite3_sql(handle_.get()); }

 private:
  void Note(int code);

  sqlite3* database_;
  StatementHandle handle_;
  absl::Status status_;
  int next_parameter_ = 1;
};

// Converts an SQLite result code, extended or not, other than OK, ROW and DONE. The message
// contains the file name and SQLite's message.
//   CORRUPT, NOTADB -> DATA_LOSS             FULL, NOMEM -> RESOURCE_EXHAUSTED
//   IOERR of a read -> DATA_LOSS             a UNIQUE or PRIMARY KEY constraint -> ALREADY_EXISTS
//   other IOERR, BUSY, LOCKED, CANTOPEN, PROTOCOL, READONLY, PERM -> UNAVAILABLE
//   TOOBIG -> INVALID_ARGUMENT               INTERRUPT -> CANCELLED
//   any other -> INTERNAL
absl::Status SqliteError(sqlite3* database, int code);

}  // namespace motiondb::storage
