#include "storage/sqlite/sqlite_connection.h"

#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "core/motion/error.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/index_corruption.h"
#include "storage/sqlite/row_checksum.h"

namespace motiondb::storage {

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
