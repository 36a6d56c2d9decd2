// The tables whose rows have a checksum, `row_crc`, which each engine computes in its own way.
// (Rows of chunks have none: each chunk contains a checksum.) The functions run in the caller's
// transaction.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

std::span<const std::string_view> CheckedTables();
// Returns the key column of a checked table.
std::string_view KeyOfTable(std::string_view table);
// Returns all columns of a checked table but `row_crc`, separated by ", ". The first is the key.
std::string_view ChecksumColumns(std::string_view table);

// A row whose checksum does not match its columns.
struct ChangedRow {
  std::string resource;  // resource name, as in Corruption; empty if it has none
  std::string row;       // "row 7 of table clip"
};

// Returns the first 100 rows of a checked table for which `condition` (SQL) is true.
absl::StatusOr<std::vector<ChangedRow>> FindRows(Connection& connection, std::string_view table,
                                                 std::string_view condition);

}  // namespace motiondb::storage
