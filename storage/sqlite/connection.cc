#include "storage/sqlite/connection.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/row_checksum.h"
#include "storage/sqlite/statement.h"

namespace motiondb::storage {

absl::StatusOr<std::unique_ptr<Connection>> Connection::Open(const std::string& path, int flags,
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
  return std::unique_ptr<Connection>(new Connection(std::move(handle)));
}

absl::Status Connection::Execute(const std::string& script) {
  const int code = sqlite3_exec(handle_.get(), script.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return SqliteError(handle_.get(), code);
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> Connection::QueryInteger(std::string_view sql) {
  Statement statement = Query(sql);
  MOTIONDB_ASSIGN_OR_RETURN(const bool row, statement.Step());
  if (!row) return core::NotFound("expected a row, got none from '{}'", sql);
  return statement.Integer(0);
}

Statement Connection::Prepare(std::string_view sql) {
  if (const auto idle = idle_.find(sql); idle != idle_.end()) {
    StatementHandle handle = std::move(idle->second);
    idle_.erase(idle);
    return Statement(*this, std::move(handle), absl::OkStatus());
  }
  sqlite3_stmt* prepared = nullptr;
  const int code = sqlite3_prepare_v3(handle_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &prepared, nullptr);
  absl::Status status;
  if (code != SQLITE_OK) status = SqliteError(handle_.get(), code);
  return Statement(*this, StatementHandle(prepared), std::move(status));
}

void Connection::GiveBack(StatementHandle statement) {
  const char* sql = sqlite3_sql(statement.get());
  idle_.emplace(sql, std::move(statement));
}

}  // namespace motiondb::storage
