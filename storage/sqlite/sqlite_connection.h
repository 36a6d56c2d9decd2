// A connection to an SQLite file, its prepared statements, and its errors as statuses.
#pragma once

#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/connection/statement.h"

namespace motiondb::storage {

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using StatementHandle = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

// A prepared statement. One that failed to be prepared has no handle, and its first Step returns
// the error.
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

// Has a cache of prepared statements. Only one thread at a time may use it.
class SqliteConnection final : public Connection {
 public:
  // `path` must be absolute or ":memory:": SQLite may interpret a name that begins with "file:" as
  // a URI. `flags`: see sqlite3_open_v2. `vfs`: name of an SQLite VFS, empty for the default.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& path, int flags,
                                                          const std::string& vfs);

  absl::Status Execute(const std::string& script) override;
  int changes() const override { return sqlite3_changes(handle_.get()); }

  absl::Status BeginTransaction(TransactionKind kind) override;
  absl::Status CommitTransaction() override;
  void RollBackTransaction() override;
  bool MayRunAgain(const absl::Status&, int) const override { return false; }

  absl::Status OfTexts(const absl::Status& status) const override;
  absl::Status FlushTexts() override;

  absl::Status SetRowChecksum(std::string_view table, std::int64_t key) override;
  std::string ChecksumOf(std::string_view values) const override;

  std::string RowIsChanged(std::string_view table) const override;
  absl::StatusOr<std::vector<std::int64_t>> FreeKeys(std::string_view table, std::string_view key,
                                                     int count) override;
  // A new key is above the largest one.
  absl::Status SkipUsedKeys(std::string_view, std::string_view) override {
    return absl::OkStatus();
  }

  // A write transaction excludes others.
  std::string_view row_lock() const override { return ""; }
  // SQLite reads row by row.
  std::int64_t max_chunk_rows() const override { return std::numeric_limits<std::int64_t>::max(); }
  bool is_usable() const override { return true; }

  sqlite3* handle() const { return handle_.get(); }

 protected:
  std::unique_ptr<PreparedStatement> Prepare(std::string_view sql) override;
  void GiveBack(std::unique_ptr<PreparedStatement> statement) override;
  std::string InsertSql(std::string_view sql, std::string_view key) const override;
  absl::StatusOr<std::int64_t> RunInsert(Statement statement) override;
  absl::Status RunInsertRow(std::string_view table, Statement statement) override;

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };

  explicit SqliteConnection(std::unique_ptr<sqlite3, Close> handle) : handle_(std::move(handle)) {}

  std::unique_ptr<sqlite3, Close> handle_;
  // Unused statements by SQL text. A statement that was used twice at a time has two entries.
  std::multimap<std::string, std::unique_ptr<SqliteStatement>, std::less<>> idle_;
};

// REQUIRES: an SqliteConnection, as all connections to the file of a store.
inline sqlite3* HandleOf(const Connection& connection) {
  return static_cast<const SqliteConnection&>(connection).handle();
}

}  // namespace motiondb::storage
