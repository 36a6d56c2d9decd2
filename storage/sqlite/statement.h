// A prepared SQL statement with bound parameters, borrowed from a connection.
//
// Keeps the first error; Step or Run returns it. The destructor returns the statement to the
// connection, which must outlive it.
#pragma once

#include <sqlite3.h>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::storage {

class Connection;

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

class Statement {
 public:
  // Called by Connection::Query. `handle` is null if `status` is an error.
  Statement(Connection& connection, StatementHandle handle, absl::Status status)
      : connection_(&connection), handle_(std::move(handle)), status_(std::move(status)) {}
  Statement(Statement&&) = default;
  Statement& operator=(Statement&&) = delete;
  ~Statement();

  // Binds the next parameter. Text is copied; a blob must outlive the statement or its next Reset.
  void Bind(std::integral auto value) { BindInteger(static_cast<std::int64_t>(value)); }
  void Bind(double value);
  void Bind(std::string_view text);
  void Bind(const std::string& text) { Bind(std::string_view(text)); }
  void Bind(const char* text) { Bind(std::string_view(text)); }
  void Bind(std::span<const std::byte> blob);
  void Bind(std::nullptr_t);
  // Binds a copy of a column of another statement's row.
  void BindColumn(const Statement& row, int column);
  // Binds NULL if there is no value.
  template <typename Value>
  void Bind(const std::optional<Value>& value) {
    if (value) {
      Bind(*value);
    } else {
      Bind(nullptr);
    }
  }

  // Moves to the next row. Returns false after the last one.
  absl::StatusOr<bool> Step();
  // Runs to the end; ignores rows.
  absl::Status Run();
  // Moves back before the first row and clears the parameters.
  void Reset();

  // Columns of the current row, numbered from 0. Tables are STRICT: the types are the declared
  // ones.
  std::int64_t Integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
  template <std::integral T>
  T Integer(int column) const {
    return static_cast<T>(Integer(column));
  }
  bool IsNull(int column) const {
    return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL;
  }
  bool IsBlob(int column) const {
    return sqlite3_column_type(handle_.get(), column) == SQLITE_BLOB;
  }
  double Real(int column) const { return sqlite3_column_double(handle_.get(), column); }
  std::string Text(int column) const;
  // Valid until the next Step, Reset or the end of the statement.
  std::span<const std::byte> Blob(int column) const;

 private:
  void BindInteger(std::int64_t value);
  void Note(int code);

  Connection* connection_;
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
