// Checksums of rows, to detect changes that SQLite did not make. The column `row_crc` contains the
// CRC-32 of the other columns of the row, which the SQL function `motiondb_crc` computes. The
// functions run in the caller's transaction.
//
// Code that inserts or updates a row must call UpdateRowChecksum or insert `motiondb_crc(...)`.
// Rows of chunks have no `row_crc`: each chunk contains a checksum.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/table_lists.h"

namespace motiondb::storage {

// Adds the SQL function `motiondb_crc` to a connection. Returns an SQLite result code.
int AddChecksumFunction(sqlite3* database);

// `key` is the row id. REQUIRES: the table is one of CheckedTables.
absl::Status UpdateRowChecksum(Connection& connection, std::string_view table, std::int64_t key);

// Returns the first 100 changed rows of a table.
absl::StatusOr<std::vector<ChangedRow>> FindChangedRows(Connection& connection,
                                                        std::string_view table);

}  // namespace motiondb::storage
