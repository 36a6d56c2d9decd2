#include <catch2/catch.hpp>

#include "storage/sqlite/sqlite_connection.h"
#include "tests/storage/require_ok.h"
#include "tests/storage/store_file.h"

namespace motiondb::tests::sqlite_status_test {

TEST_CASE("SqliteError: each code has its status", "[storage][status]") {
  using absl::StatusCode;
  const std::pair<int, StatusCode> table[] = {
      {SQLITE_CORRUPT, StatusCode::kDataLoss},
      {SQLITE_CORRUPT_INDEX, StatusCode::kDataLoss},
      {SQLITE_NOTADB, StatusCode::kDataLoss},
      {SQLITE_FULL, StatusCode::kResourceExhausted},
      {SQLITE_NOMEM, StatusCode::kResourceExhausted},
      {SQLITE_IOERR_READ, StatusCode::kDataLoss},
      {SQLITE_IOERR_SHORT_READ, StatusCode::kDataLoss},
      {SQLITE_IOERR_CORRUPTFS, StatusCode::kDataLoss},
      {SQLITE_IOERR_DATA, StatusCode::kDataLoss},
      {SQLITE_IOERR, StatusCode::kUnavailable},
      {SQLITE_IOERR_NOMEM, StatusCode::kUnavailable},
      {SQLITE_IOERR_FSYNC, StatusCode::kUnavailable},
      {SQLITE_IOERR_WRITE, StatusCode::kUnavailable},
      {SQLITE_BUSY, StatusCode::kUnavailable},
      {SQLITE_BUSY_SNAPSHOT, StatusCode::kUnavailable},
      {SQLITE_LOCKED, StatusCode::kUnavailable},
      {SQLITE_CANTOPEN, StatusCode::kUnavailable},
      {SQLITE_PROTOCOL, StatusCode::kUnavailable},
      {SQLITE_CONSTRAINT_UNIQUE, StatusCode::kAlreadyExists},
      {SQLITE_CONSTRAINT_PRIMARYKEY, StatusCode::kAlreadyExists},
      {SQLITE_CONSTRAINT_FOREIGNKEY, StatusCode::kInternal},
      {SQLITE_CONSTRAINT_CHECK, StatusCode::kInternal},
      {SQLITE_READONLY, StatusCode::kUnavailable},
      {SQLITE_READONLY_DBMOVED, StatusCode::kUnavailable},
      {SQLITE_PERM, StatusCode::kUnavailable},
      {SQLITE_TOOBIG, StatusCode::kInvalidArgument},
      {SQLITE_MISUSE, StatusCode::kInternal},
  };
  for (const auto& [code, expected] : table) {
    REQUIRE_ERROR(storage::SqliteError(nullptr, code), expected, sqlite3_errstr(code));
  }
}

TEST_CASE("SqliteMotionStore: uses the given VFS", "[storage][open]") {
  const StoreFile file;
  REQUIRE_OK(file.TryOpen({.reader_count = 1, .now_us = {}, .vfs = "unix"}));
  REQUIRE_ERROR(file.TryOpen({.reader_count = 1, .now_us = {}, .vfs = "none such"}),
                absl::StatusCode::kInternal, "no such vfs: none such");
}

}  // namespace motiondb::tests::sqlite_status_test
