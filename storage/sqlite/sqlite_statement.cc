#include "storage/sqlite/sqlite_statement.h"

#include <fmt/format.h>

namespace motiondb::storage {

void SqliteStatement::BindReal(double value) {
  Note(sqlite3_bind_double(handle_.get(), next_parameter_++, value));
}

void SqliteStatement::BindText(std::string_view text) {
  // A null pointer would bind NULL.
  Note(sqlite3_bind_text64(handle_.get(), next_parameter_++, text.empty() ? "" : text.data(),
                           text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
}

void SqliteStatement::BindBlob(std::span<const std::byte> blob) {
  Note(sqlite3_bind_blob64(handle_.get(), next_parameter_++,
                           blob.empty() ? static_cast<const void*>("") : blob.data(), blob.size(),
                           SQLITE_STATIC));
}

void SqliteStatement::BindNull() { Note(sqlite3_bind_null(handle_.get(), next_parameter_++)); }

void SqliteStatement::BindInteger(std::int64_t value) {
  Note(sqlite3_bind_int64(handle_.get(), next_parameter_++, value));
}

void SqliteStatement::Note(int code) {
  if (code != SQLITE_OK && status_.ok()) status_ = SqliteError(database_, code);
}

absl::StatusOr<bool> SqliteStatement::Step() {
  if (!status_.ok()) return status_;
  const int code = sqlite3_step(handle_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  status_ = SqliteError(database_, code);
  return status_;
}

void SqliteStatement::Reset() {
  if (handle_ == nullptr) return;
  sqlite3_reset(handle_.get());
  sqlite3_clear_bindings(handle_.get());
  next_parameter_ = 1;
  status_ = absl::OkStatus();
}

ColumnType SqliteStatement::Type(int column) const {
  switch (sqlite3_column_type(handle_.get(), column)) {
    case SQLITE_INTEGER:
      return ColumnType::kInteger;
    case SQLITE_FLOAT:
      return ColumnType::kReal;
    case SQLITE_TEXT:
      return ColumnType::kText;
    case SQLITE_BLOB:
      return ColumnType::kBlob;
    default:
      return ColumnType::kNull;
  }
}

std::string SqliteStatement::Text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column));
  return text == nullptr ? std::string() : std::string(text, size);
}

std::span<const std::byte> SqliteStatement::Blob(int column) const {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(handle_.get(), column));
  const auto size = static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column));
  return {bytes, size};
}

namespace {

absl::StatusCode ToStatusCode(int code) {
  if (code == SQLITE_CONSTRAINT_UNIQUE || code == SQLITE_CONSTRAINT_PRIMARYKEY) {
    return absl::StatusCode::kAlreadyExists;
  }
  // Data that the disk cannot read is lost, like corrupt data. SQLite repeats reads that a signal
  // interrupted, and reports EIO mostly as SQLITE_CORRUPT.
  if (code == SQLITE_IOERR_READ || code == SQLITE_IOERR_SHORT_READ ||
      code == SQLITE_IOERR_CORRUPTFS || code == SQLITE_IOERR_DATA) {
    return absl::StatusCode::kDataLoss;
  }
  switch (code & 0xff) {  // the primary code
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::StatusCode::kDataLoss;
    case SQLITE_FULL:
    case SQLITE_NOMEM:
      return absl::StatusCode::kResourceExhausted;
    case SQLITE_IOERR:
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_CANTOPEN:
    case SQLITE_PROTOCOL:
    // Not PERMISSION_DENIED, which would suggest that the caller needs another role.
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return absl::StatusCode::kUnavailable;
    case SQLITE_INTERRUPT:
      return absl::StatusCode::kCancelled;
    case SQLITE_TOOBIG:
      return absl::StatusCode::kInvalidArgument;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

absl::Status SqliteError(sqlite3* database, int code) {
  const char* file = database == nullptr ? nullptr : sqlite3_db_filename(database, "main");
  // The connection's message has more detail if it belongs to this error.
  const bool own = database != nullptr && sqlite3_errcode(database) == code;
  return absl::Status(
      ToStatusCode(code),
      fmt::format("{}: {} (SQLite error {})", file == nullptr || *file == '\0' ? "store" : file,
                  own ? sqlite3_errmsg(database) : sqlite3_errstr(code), code));
}

}  // namespace motiondb::storage
