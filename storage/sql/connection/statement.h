// A prepared SQL statement with bound parameters, borrowed from a connection: the part of a
// database engine that the tables of a store use. Parameters are written as in SQLite: `?` is the
// next one, `?3` number 3.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::storage {

class Connection;

enum class ColumnType { kNull, kInteger, kReal, kText, kBlob };

// What an engine implements. Keeps the first error, which Step returns.
class PreparedStatement {
 public:
  virtual ~PreparedStatement() = default;

  // Bind the next parameter. A blob must outlive the statement or its next Reset.
  virtual void BindInteger(std::int64_t value) = 0;
  virtual void BindReal(double value) = 0;
  virtual void BindText(std::string_view text) = 0;
  virtual void BindBlob(std::span<const std::byte> blob) = 0;
  virtual void BindNull() = 0;

  virtual absl::StatusOr<bool> Step() = 0;
  // Runs the statement with a later one. Returns false, and does nothing, if the engine does not.
  virtual absl::StatusOr<bool> Queue() { return false; }
  virtual void Reset() = 0;

  // See Statement.
  virtual std::int64_t Integer(int column) const = 0;
  virtual double Real(int column) const = 0;
  virtual std::string Text(int column) const = 0;
  virtual std::span<const std::byte> Blob(int column) const = 0;
  virtual ColumnType Type(int column) const = 0;
};

// Keeps the first error; Step or Run returns it. The destructor returns the statement to the
// connection, which must outlive it.
class Statement {
 public:
  // Called by Connection::Query.
  Statement(Connection& connection, std::unique_ptr<PreparedStatement> prepared)
      : connection_(&connection), prepared_(std::move(prepared)) {}
  Statement(Statement&&) = default;
  Statement& operator=(Statement&&) = delete;
  ~Statement();

  // Binds the next parameter. Text is copied; a blob must outlive the statement or its next Reset.
  void Bind(std::integral auto value) { prepared_->BindInteger(static_cast<std::int64_t>(value)); }
  void Bind(double value) { prepared_->BindReal(value); }
  void Bind(std::string_view text) { prepared_->BindText(text); }
  void Bind(const std::string& text) { prepared_->BindText(text); }
  void Bind(const char* text) { prepared_->BindText(text); }
  void Bind(std::span<const std::byte> blob) { prepared_->BindBlob(blob); }
  void Bind(std::nullptr_t) { prepared_->BindNull(); }
  // Binds a column of a statement's row, of any engine. The row must stay the current one as long
  // as a blob must.
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
  absl::StatusOr<bool> Step() { return prepared_->Step(); }
  // Runs to the end; ignores rows.
  absl::Status Run();
  // As Run, for a statement of a write transaction whose result is not used, not even the number
  // of changed rows. An engine on another machine may send it with a later statement, so that the
  // transaction waits less often; its error is then that of a later statement or of the commit. A
  // blob need not outlive the call.
  absl::Status RunLater();
  // Moves back before the first row and clears the parameters.
  void Reset() { prepared_->Reset(); }

  // Columns of the current row, numbered from 0. REQUIRES: the declared type of the column.
  std::int64_t Integer(int column) const { return prepared_->Integer(column); }
  template <std::integral T>
  T Integer(int column) const {
    return static_cast<T>(Integer(column));
  }
  ColumnType Type(int column) const { return prepared_->Type(column); }
  bool IsNull(int column) const { return Type(column) == ColumnType::kNull; }
  bool IsBlob(int column) const { return Type(column) == ColumnType::kBlob; }
  double Real(int column) const { return prepared_->Real(column); }
  std::string Text(int column) const { return prepared_->Text(column); }
  // Valid until the next Step, Reset or the end of the statement.
  std::span<const std::byte> Blob(int column) const { return prepared_->Blob(column); }

 private:
  Connection* connection_;
  std::unique_ptr<PreparedStatement> prepared_;
};

}  // namespace motiondb::storage
