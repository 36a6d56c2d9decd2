#include "storage/sqlite/sqlite_status.h"

#include <fmt/format.h>

namespace motiondb::storage {
namespace {

absl::StatusCode ToStatusCode(int code) {
  if (code == SQLITE_CONSTRAINT_UNIQUE || code == SQLITE_CONSTRAINT_PRIMARYKEY) {
    return absl::StatusCode::kAlreadyExists;
  }
  // What the disk cannot give back, or not as it was, costs what is on it, as damage does. SQLite
  // repeats a read that a signal broke off, and mostly tells EIO as SQLITE_CORRUPT.
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
    // The disk's state, not the caller's rights: PERMISSION_DENIED would ask them for another role.
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return absl::StatusCode::kUnavailable;
    case SQLITE_TOOBIG:
      return absl::StatusCode::kInvalidArgument;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

absl::Status SqliteError(sqlite3* database, int code) {
  const char* file = database == nullptr ? nullptr : sqlite3_db_filename(database, "main");
  // The connection's own message tells more, where it is about this error.
  const bool own = database != nullptr && sqlite3_errcode(database) == code;
  return absl::Status(
      ToStatusCode(code),
      fmt::format("{}: {} (SQLite error {})", file == nullptr || *file == '\0' ? "store" : file,
                  own ? sqlite3_errmsg(database) : sqlite3_errstr(code), code));
}

}  // namespace motiondb::storage
