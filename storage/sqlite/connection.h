// A connection to an SQLite file, with a cache of prepared statements. Only one thread at a time
// may use it.
#pragma once

#include <sqlite3.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/sqlite/statement.h"

namespace motiondb::storage {

class Connection {
 public:
  // `path` must be absolute or ":memory:": SQLite may interpret a name that begins with "file:" as
  // a URI. `flags`: see sqlite3_open_v2. `vfs`: name of an SQLite VFS, empty for the default.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& path, int flags,
                                                          const std::string& vfs);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Runs a script of statements without parameters; ignores result rows.
  absl::Status Execute(const std::string& script);

  // Returns a statement with its parameters bound in order. Each SQL text is prepared once.
  template <typename... Args>
  Statement Query(std::string_view sql, const Args&... args) {
    Statement statement = Prepare(sql);
    (statement.Bind(args), ...);
    return statement;
  }
  // Returns the first column of the first row. NOT_FOUND if there is no row.
  absl::StatusOr<std::int64_t> QueryInteger(std::string_view sql);

  std::int64_t last_insert_key() const { return sqlite3_last_insert_rowid(handle_.get()); }
  // Returns the number of rows that the last INSERT, UPDATE or DELETE changed.
  int changes() const { return sqlite3_changes(handle_.get()); }
  bool in_transaction() const { return sqlite3_get_autocommit(handle_.get()) == 0; }
  sqlite3* handle() const { return handle_.get(); }

 private:
  friend class Statement;
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };

  explicit Connection(std::unique_ptr<sqlite3, Close> handle) : handle_(std::move(handle)) {}
  Statement Prepare(std::string_view sql);
  void GiveBack(StatementHandle statement);

  std::unique_ptr<sqlite3, Close> handle_;
  // Unused statements by SQL text. A statement that was used twice at a time has two entries.
  std::multimap<std::string, StatementHandle, std::less<>> idle_;
};

}  // namespace motiondb::storage
