// Lists of the tables of a store and of their columns: those whose rows have a checksum, and those
// whose rows are copied.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// The tables whose rows have a checksum, `row_crc`, which each engine computes in its own way.
// (Rows of chunks have none: each chunk contains a checksum.)
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

// Returns the first 100 rows of a checked table for which `condition` (SQL) is true. In the
// caller's transaction.
absl::StatusOr<std::vector<ChangedRow>> FindRows(Connection& connection, std::string_view table,
                                                 std::string_view condition);

struct CopiedColumn {
  std::string name;
  std::string refers_to;  // the table whose key it contains; empty: none
  bool is_key = false;    // of the row itself
};

struct CopiedTable {
  std::string_view name;
  std::string_view keys;   // its primary key: one or two columns of integers
  std::string condition;   // SQL, of the copied rows; parameter 1 is the key of the database
  bool is_parent = false;  // other tables refer to it
  bool in_order = true;    // of the keys

  // Returns whether its rows have a column with a checksum.
  bool has_checksum() const;
  // Returns whether the key is one column, whose values only this table determines.
  bool has_own_key() const {
    return keys.find(',') == std::string_view::npos && name != "clip_text";
  }
};

// The tables with the content of one database, each after those that it refers to: not its
// operations. With `texts` also the table clip_text, which is derived from the others.
std::vector<CopiedTable> TablesOfDatabase(bool texts);
// All tables but clip_text, each after those that it refers to.
std::vector<CopiedTable> TablesOfStore();
// The table clip_text, with a condition that is always true.
CopiedTable TextTable();

// Returns the columns of a table but its checksum, the key first.
std::vector<CopiedColumn> ColumnsOf(const CopiedTable& table);
// Returns their names, separated by ", ".
std::string ColumnNames(const CopiedTable& table);

}  // namespace motiondb::storage
