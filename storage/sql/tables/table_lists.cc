#include "storage/sql/tables/table_lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

struct CheckedTable {
  std::string_view name;
  std::string_view key;
  std::string_view columns;      // all but row_crc
  std::string_view id;           // the column with the resource id; empty: none
  std::string_view parent = "";  // the table of the resource that it belongs to; empty: none
};

// The columns must match those of the last migration that sets row_crc (migrations.cc).
constexpr std::array kTables = {
    CheckedTable{"database", "database_key",
                 "database_key, name, frame_rate_hz, min_frames, scaling, marker_set, "
                 "marker_set_text, last_model_version, create_time_us, deleted, glitches, "
                 "revision, removed_revision",
                 "name"},
    CheckedTable{"clip", "clip_key",
                 "clip_key, database_key, id, subject, file_name, skeleton_file_name, "
                 "frame_count, duration_seconds, source_frame_rate_hz, leg_length_m, "
                 "skeleton_key, source_report, content_hash, root_path_crc, create_time_us, "
                 "deleted, byte_count, representation_version, tried_version, tried_time_us, "
                 "derive_error, given_metres_per_unit, given_up_axis, given_frame_rate_hz, "
                 "given_leg_length_m, format, given_take, title, description, annotations, "
                 "revision, edit_time_us",
                 "id", "database"},
    CheckedTable{"skeleton", "skeleton_key", "skeleton_key, database_key, id, encoded_crc", "id",
                 "database"},
    CheckedTable{"model", "model_key",
                 "model_key, database_key, version, current, create_time_us, build_seconds, "
                 "frame_count, clip_count, dimension_count, base_key, added_clip_count, "
                 "added_frame_count, stale_share, staged, revision",
                 "version", "database"},
    CheckedTable{"model_layer", "model_key", "model_key, layer, node_count", ""},
    CheckedTable{"model_clip", "model_key", "model_key, position, clip_key", ""},
    CheckedTable{"segment", "segment_key",
                 "segment_key, database_key, clip_key, id, track, label, start_seconds, "
                 "end_seconds, source, confidence, revision, author, create_time_us, "
                 "update_time_us",
                 "id", "clip"},
    CheckedTable{"tombstone", "tombstone_key",
                 "tombstone_key, database_key, number, revision, clip, segment", ""},
    CheckedTable{"edit", "edit_key",
                 "edit_key, database_key, number, revision, author, time_us, clips, objects",
                 "revision", "database"},
    CheckedTable{"operation", "sequence",
                 "sequence, id, database_key, state, progress, stage, model_version, error_code, "
                 "error_message, create_time_us, update_time_us, kind",
                 "id"},
    CheckedTable{"build_lease", "database_key", "database_key, holder, fence, expire_time_us", ""},
    CheckedTable{"token", "sequence",
                 "sequence, id, role, database, description, salt, secret_hash, create_time_us, "
                 "expire_time_us, revoke_time_us",
                 "id"},
    CheckedTable{"audit", "sequence",
                 "sequence, time_us, principal, peer, method, resource, code, request_id", ""},
};

// Returns an SQL expression for the resource name of a row.
std::string ResourceOf(const CheckedTable& table) {
  if (table.id.empty()) return "''";
  const std::string name = fmt::format("'{}s/' || {}.{}", table.name, table.name, table.id);
  if (table.parent.empty()) return name;
  const std::string database = fmt::format(
      "(SELECT 'databases/' || database.name || '/' FROM database WHERE database.database_key = "
      "{}.database_key)",
      table.name);
  if (table.parent == "database") return fmt::format("{} || {}", database, name);
  return fmt::format(
      "{} || (SELECT '{}s/' || id || '/' FROM {} AS parent WHERE parent.{}_key = {}.{}_key) || {}",
      database, table.parent, table.parent, table.parent, table.name, table.parent, name);
}

std::ptrdiff_t IndexOf(std::string_view table) {
  return std::ranges::find(kTables, table, &CheckedTable::name) - kTables.begin();
}

}  // namespace

std::span<const std::string_view> CheckedTables() {
  static const auto kNames = [] {
    std::array<std::string_view, kTables.size()> names;
    std::ranges::transform(kTables, names.begin(), &CheckedTable::name);
    return names;
  }();
  return kNames;
}

std::string_view ChecksumColumns(std::string_view table) {
  return kTables[static_cast<std::size_t>(IndexOf(table))].columns;
}

std::string_view KeyOfTable(std::string_view table) {
  return kTables[static_cast<std::size_t>(IndexOf(table))].key;
}

absl::StatusOr<std::vector<ChangedRow>> FindRows(Connection& connection, std::string_view table,
                                                 std::string_view condition) {
  const CheckedTable& checked = kTables[static_cast<std::size_t>(IndexOf(table))];
  Statement row =
      connection.Query(fmt::format("SELECT {}, {} FROM {} WHERE {} LIMIT 100", checked.key,
                                   ResourceOf(checked), checked.name, condition));
  std::vector<ChangedRow> changed;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return changed;
    changed.push_back({row.Text(1), fmt::format("row {} of table {}", row.Integer(0), table)});
  }
}

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
