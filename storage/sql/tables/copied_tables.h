// The tables of a store in the order in which rows are copied: each comes after those that it
// refers to.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace motiondb::storage {

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

// The tables with the content of one database: not its operations. With `texts` also the table
// clip_text, which is derived from the others.
std::vector<CopiedTable> TablesOfDatabase(bool texts);
// All tables but clip_text.
std::vector<CopiedTable> TablesOfStore();
// The table clip_text, with a condition that is always true.
CopiedTable TextTable();

// Returns the columns of a table but its checksum, the key first.
std::vector<CopiedColumn> ColumnsOf(const CopiedTable& table);
// Returns their names, separated by ", ".
std::string ColumnNames(const CopiedTable& table);

}  // namespace motiondb::storage
