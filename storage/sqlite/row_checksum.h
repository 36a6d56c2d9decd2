// Checksums of rows, so that a change of one that SQLite did not make is found. The column
// `row_crc` of a table holds the CRC-32 of the row's other columns, which the SQL function
// `motiondb_crc` gives. Functions keep no state; they run in the transaction of their caller.
//
// Who inserts or updates a row calls SetRowChecksum, or inserts `motiondb_crc(...)`. Rows of chunks
// have none: each chunk has a checksum of its own.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// Every connection has it. An SQLite result code.
int AddChecksumFunction(sqlite3* database);

// `key` is the row id. REQUIRES: the table is one of CheckedTables.
absl::Status SetRowChecksum(Connection& connection, std::string_view table, std::int64_t key);

std::span<const std::string_view> CheckedTables();

// A row whose checksum is not that of its columns.
struct ChangedRow {
  std::string resource;  // what it is, as in Damage; empty if it has no name
  std::string row;       // "row 7 of table clip"
};

// The first hundred of a table.
absl::StatusOr<std::vector<ChangedRow>> FindChangedRows(Connection& connection,
                                                        std::string_view table);

}  // namespace motiondb::storage
