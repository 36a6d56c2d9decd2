#include "storage/sqlite/sqlite_connection.h"

#include <fmt/format.h>

#include <numeric>

#include "core/motion/error.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/row_checksum.h"

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

absl::StatusOr<std::unique_ptr<Connection>> SqliteConnection::Open(const std::string& path,
                                                                   int flags,
                                                                   const std::string& vfs) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &opened, flags | SQLITE_OPEN_NOMUTEX,
                                   vfs.empty() ? nullptr : vfs.c_str());
  std::unique_ptr<sqlite3, Close> handle(opened);  // set even if opening failed
  if (code != SQLITE_OK) {
    const absl::Status error = SqliteError(handle.get(), code);
    return absl::Status(error.code(),
                        fmt::format("cannot open '{}': {}", path, std::string(error.message())));
  }
  sqlite3_extended_result_codes(handle.get(), 1);
  for (const auto add : {AddChecksumFunction, AddWordsFunction}) {
    if (const int added = add(handle.get()); added != SQLITE_OK) {
      return SqliteError(handle.get(), added);
    }
  }
  return std::unique_ptr<Connection>(new SqliteConnection(std::move(handle)));
}

absl::Status SqliteConnection::Execute(const std::string& script) {
  const int code = sqlite3_exec(handle_.get(), script.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return SqliteError(handle_.get(), code);
  return absl::OkStatus();
}

absl::Status SqliteConnection::BeginTransaction(TransactionKind kind) {
  return Query(kind == TransactionKind::kWrite ? "BEGIN IMMEDIATE" : "BEGIN").Run();
}

absl::Status SqliteConnection::CommitTransaction() {
  // Only the search index reads now: it stores what it has kept in memory.
  return OfSearchIndex(Query("COMMIT").Run());
}

void SqliteConnection::RollBackTransaction() {
  // After some errors SQLite has rolled back already. If this fails, the next Begin tries again.
  if (sqlite3_get_autocommit(handle_.get()) == 0) Query("ROLLBACK").Run().IgnoreError();
}

absl::Status SqliteConnection::OfTexts(const absl::Status& status) const {
  return OfSearchIndex(status);
}

absl::Status SqliteConnection::FlushTexts() {
  // FTS5 writes what it has kept in memory.
  for (const char* const flush : {"SAVEPOINT clip_text", "RELEASE clip_text"}) {
    MOTIONDB_RETURN_IF_ERROR(OfSearchIndex(Query(flush).Run()));
  }
  return absl::OkStatus();
}

absl::Status SqliteConnection::SetRowChecksum(std::string_view table, std::int64_t key) {
  return UpdateRowChecksum(*this, table, key);
}

std::string SqliteConnection::ChecksumOf(std::string_view values) const {
  return fmt::format("motiondb_crc({})", values);
}

std::string SqliteConnection::RowIsChanged(std::string_view table) const {
  return fmt::format("row_crc IS NOT motiondb_crc({})", ChecksumColumns(table));
}

absl::StatusOr<std::vector<std::int64_t>> SqliteConnection::FreeKeys(std::string_view table,
                                                                     std::string_view key,
                                                                     int count) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t last,
      QueryInteger(fmt::format("SELECT ifnull(max({}), 0) FROM {}", key, table)));
  std::vector<std::int64_t> keys(static_cast<std::size_t>(count));
  std::iota(keys.begin(), keys.end(), last + 1);
  return keys;
}

std::string SqliteConnection::InsertSql(std::string_view sql, std::string_view) const {
  return std::string(sql);
}

absl::StatusOr<std::int64_t> SqliteConnection::RunInsert(Statement statement) {
  MOTIONDB_RETURN_IF_ERROR(statement.Run());
  return sqlite3_last_insert_rowid(handle_.get());
}

absl::Status SqliteConnection::RunInsertRow(std::string_view table, Statement statement) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, RunInsert(std::move(statement)));
  return SetRowChecksum(table, key);
}

std::unique_ptr<PreparedStatement> SqliteConnection::Prepare(std::string_view sql) {
  if (const auto idle = idle_.find(sql); idle != idle_.end()) {
    std::unique_ptr<SqliteStatement> statement = std::move(idle->second);
    idle_.erase(idle);
    return statement;
  }
  sqlite3_stmt* prepared = nullptr;
  const int code = sqlite3_prepare_v3(handle_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &prepared, nullptr);
  absl::Status status;
  if (code != SQLITE_OK) status = SqliteError(handle_.get(), code);
  return std::make_unique<SqliteStatement>(handle_.get(), StatementHandle(prepared),
                                           std::move(status));
}

void SqliteConnection::GiveBack(std::unique_ptr<PreparedStatement> statement) {
  std::unique_ptr<SqliteStatement> prepared(static_cast<SqliteStatement*>(statement.release()));
  const char* const sql = prepared->sql();
  if (sql != nullptr) idle_.emplace(sql, std::move(prepared));
}

}  // namespace motiondb::storage
