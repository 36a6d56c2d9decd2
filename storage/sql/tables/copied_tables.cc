#include "storage/sql/tables/copied_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "storage/sql/tables/checked_tables.h"

namespace motiondb::storage {
namespace {

constexpr std::string_view kChunk = "_chunk";
constexpr std::string_view kTextTable = "clip_text";

// Conditions of the rows of one database. A deleted clip is kept for a model.
constexpr std::string_view kOfDatabase = "database_key = ?1";
constexpr std::string_view kModels = "database_key = ?1 AND staged = 0";
constexpr std::string_view kClips =
    "database_key = ?1 AND (deleted = 0 OR clip_key IN (SELECT clip_key FROM model_clip JOIN model "
    "USING (model_key) WHERE database_key = ?1 AND staged = 0))";

struct TableOfDatabase {
  std::string_view name;
  std::string_view keys;
  std::string_view parent;     // the table whose copied rows its rows belong to; empty: none
  std::string_view condition;  // if it has no parent
};

constexpr std::array kTablesOfDatabase = {
    TableOfDatabase{"database", "database_key", "", kOfDatabase},
    TableOfDatabase{"skeleton", "skeleton_key", "", kOfDatabase},
    TableOfDatabase{"skeleton_chunk", "chunk_key", "skeleton", ""},
    TableOfDatabase{"model", "model_key", "", kModels},
    TableOfDatabase{"model_layer", "model_key, layer", "model", ""},
    TableOfDatabase{"model_chunk", "chunk_key", "model", ""},
    TableOfDatabase{"clip", "clip_key", "", kClips},
    TableOfDatabase{"clip_chunk", "chunk_key", "clip", ""},
    TableOfDatabase{"model_clip", "model_key, position", "model", ""},
    TableOfDatabase{"segment", "segment_key", "clip", ""},
    TableOfDatabase{"tombstone", "tombstone_key", "", kOfDatabase},
    TableOfDatabase{"edit", "edit_key", "", kOfDatabase},
    TableOfDatabase{kTextTable, "rowid", "clip", ""}};

std::string ConditionOf(const TableOfDatabase& table) {
  if (table.parent.empty()) return std::string(table.condition);
  const auto* const parent =
      std::ranges::find(kTablesOfDatabase, table.parent, &TableOfDatabase::name);
  return fmt::format("{} IN (SELECT {}_key FROM {} WHERE {})",
                     table.name == kTextTable ? "rowid" : fmt::format("{}_key", table.parent),
                     table.parent, table.parent, parent->condition);
}

bool IsParent(std::string_view table) {
  return table == "database" ||
         std::ranges::count(kTablesOfDatabase, table, &TableOfDatabase::parent) > 0;
}

// Returns the table whose key a column contains; empty: none.
std::string TableOfKey(std::string_view column) {
  if (column == "base_key") return "model";
  if (column == "rowid") return "clip";
  constexpr std::string_view kKey = "_key";
  return column.ends_with(kKey) ? std::string(column.substr(0, column.size() - kKey.size())) : "";
}

}  // namespace

bool CopiedTable::has_checksum() const { return name != kTextTable && !name.ends_with(kChunk); }

std::vector<CopiedTable> TablesOfDatabase(bool texts) {
  std::vector<CopiedTable> tables;
  for (const TableOfDatabase& table : kTablesOfDatabase) {
    if (table.name == kTextTable && !texts) continue;
    // An extension of a model comes after its build, to which it refers. To sort chunks would copy
    // them.
    tables.push_back({table.name, table.keys, ConditionOf(table), IsParent(table.name),
                      /*in_order=*/table.parent.empty()});
  }
  return tables;
}

std::vector<CopiedTable> TablesOfStore() {
  std::vector<CopiedTable> tables = TablesOfDatabase(/*texts=*/false);
  for (const std::string_view name : {"operation", "token", "audit"}) {
    tables.push_back({.name = name, .keys = "sequence", .condition = ""});
  }
  for (CopiedTable& table : tables) {
    table.condition = "TRUE";
    table.in_order = true;
  }
  return tables;
}

CopiedTable TextTable() { return {.name = kTextTable, .keys = "rowid", .condition = "TRUE"}; }

std::string ColumnNames(const CopiedTable& table) {
  if (table.has_checksum()) return std::string(ChecksumColumns(table.name));
  if (table.name == kTextTable)
    return "rowid, title, description, tags, labels, subject, file_name";
  const std::string_view owner = table.name.substr(0, table.name.size() - kChunk.size());
  return fmt::format("chunk_key, {}_key, kind, position, chunk", owner);
}

std::vector<CopiedColumn> ColumnsOf(const CopiedTable& table) {
  std::vector<CopiedColumn> columns;
  const std::string names = ColumnNames(table);
  for (std::string_view rest = names; !rest.empty();) {
    const std::size_t size = std::min(rest.find(", "), rest.size());
    CopiedColumn& column = columns.emplace_back();
    column.name = rest.substr(0, size);
    rest.remove_prefix(std::min(size + 2, rest.size()));
    column.is_key = columns.size() == 1 && table.has_own_key();
    if (!column.is_key) column.refers_to = TableOfKey(column.name);
  }
  return columns;
}

}  // namespace motiondb::storage
