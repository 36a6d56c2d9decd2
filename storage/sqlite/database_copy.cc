#include "storage/sqlite/database_copy.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/motion/error.h"
#include "storage/sqlite/index_corruption.h"
#include "storage/sqlite/row_checksum.h"

namespace motiondb::storage {
namespace {

constexpr int kStepRows = 256;  // at most, in one step

constexpr std::string_view kChunkColumns = "kind, position, chunk";
constexpr std::string_view kTextTable = "clip_text";
constexpr std::string_view kTextColumns =
    "rowid, title, description, tags, labels, subject, file_name";

// Conditions of the copied rows; parameter 1 is the key of the database. A deleted clip is kept for
// a model.
constexpr std::string_view kOfDatabase = "database_key = ?1";
constexpr std::string_view kModels = "database_key = ?1 AND staged = 0";
constexpr std::string_view kClips =
    "database_key = ?1 AND (deleted = 0 OR clip_key IN (SELECT clip_key FROM model_clip JOIN model "
    "USING (model_key) WHERE database_key = ?1 AND staged = 0))";

struct CopiedTable {
  std::string_view name;
  std::string_view parent;     // the table whose copied rows its rows belong to; empty: none
  std::string_view condition;  // if it has no parent
};

// Each table comes after those that it refers to. The text table is the last.
constexpr std::array kCopiedTables = {CopiedTable{"database", "", kOfDatabase},
                                      CopiedTable{"skeleton", "", kOfDatabase},
                                      CopiedTable{"skeleton_chunk", "skeleton", ""},
                                      CopiedTable{"model", "", kModels},
                                      CopiedTable{"model_layer", "model", ""},
                                      CopiedTable{"model_chunk", "model", ""},
                                      CopiedTable{"clip", "", kClips},
                                      CopiedTable{"clip_chunk", "clip", ""},
                                      CopiedTable{"model_clip", "model", ""},
                                      CopiedTable{"segment", "clip", ""},
                                      CopiedTable{"tombstone", "", kOfDatabase},
                                      CopiedTable{"edit", "", kOfDatabase},
                                      CopiedTable{kTextTable, "clip", ""}};

std::string ConditionOf(const CopiedTable& table) {
  if (table.parent.empty()) {
    // An extension of a model comes after its build, to which it refers.
    return fmt::format("{} ORDER BY {}_key", table.condition, table.name);
  }
  const auto* const parent = std::ranges::find(kCopiedTables, table.parent, &CopiedTable::name);
  return fmt::format("{} IN (SELECT {}_key FROM {} WHERE {})",
                     table.name == kTextTable ? "rowid" : fmt::format("{}_key", table.parent),
                     table.parent, table.parent, parent->condition);
}

bool IsReferredTo(std::string_view table) {
  return table == kCopiedTables.front().name ||
         std::ranges::count(kCopiedTables, table, &CopiedTable::parent) > 0;
}

std::string ColumnsOf(std::string_view table) {
  if (table == kTextTable) return std::string(kTextColumns);
  constexpr std::string_view kChunk = "_chunk";
  if (!table.ends_with(kChunk)) return std::string(ChecksumColumns(table));
  table.remove_suffix(kChunk.size());
  return fmt::format("chunk_key, {}_key, {}", table, kChunkColumns);
}

bool HasChecksum(std::string_view table) {
  return table != kTextTable && !table.ends_with("_chunk");
}

// Returns the table whose key a column contains; empty: none.
std::string TableOfKey(std::string_view column) {
  if (column == "base_key") return "model";
  if (column == "rowid") return "clip";
  constexpr std::string_view kKey = "_key";
  return column.ends_with(kKey) ? std::string(column.substr(0, column.size() - kKey.size())) : "";
}

}  // namespace

DatabaseCopy::DatabaseCopy(Connection& source, std::int64_t database_key, Keys keys)
    : source_(source), database_key_(database_key), keys_(keys) {}

absl::StatusOr<bool> DatabaseCopy::Step(Connection& target) {
  // The index is derived from the rows, so that its corruption does not prevent an export.
  const std::size_t table_count = kCopiedTables.size() - (keys_ == Keys::kSame ? 1 : 0);
  next_key_ = 0;
  std::int64_t bytes = 0;
  for (int rows = 0; rows < kStepRows && bytes < kStepBytes;) {
    if (table_ == table_count) return false;
    if (!rows_) BeginTable();
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, rows_->Step());
    if (found) {
      MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t copied, CopyRow(target));
      bytes += copied;
      ++rows;
      continue;
    }
    rows_.reset();
    next_key_ = 0;
    ++table_;
  }
  return true;
}

void DatabaseCopy::BeginTable() {
  const CopiedTable& table = kCopiedTables[table_];
  const std::string names = ColumnsOf(table.name);
  columns_.clear();
  std::string parameters;
  for (std::string_view rest = names; !rest.empty();) {
    const std::size_t size = std::min(rest.find(", "), rest.size());
    Column& column = columns_.emplace_back();
    column.name = rest.substr(0, size);
    rest.remove_prefix(std::min(size + 2, rest.size()));
    const std::string refers_to = TableOfKey(column.name);
    // The first column, if it is the key of the row: `base_key` is that of another model.
    column.is_key = columns_.size() == 1 && (refers_to == table.name || refers_to == "chunk");
    if (!column.is_key) column.refers_to = refers_to;
    parameters += fmt::format("{}?{}", parameters.empty() ? "" : ", ", columns_.size());
  }
  std::string select = names;
  std::string into = names;
  std::string values = parameters;
  if (HasChecksum(table.name)) {
    into += ", row_crc";
    if (keys_ == Keys::kSame) {
      select += ", row_crc";
      columns_.emplace_back().name = "row_crc";
      values += fmt::format(", ?{}", columns_.size());
    } else {
      values += fmt::format(", motiondb_crc({})", parameters);
    }
  }
  insert_ = fmt::format("INSERT INTO {} ({}) VALUES ({})", table.name, into, values);
  rows_.emplace(source_.Query(
      fmt::format("SELECT {} FROM {} WHERE {}", select, table.name, ConditionOf(table)),
      database_key_));
}

absl::StatusOr<std::int64_t> DatabaseCopy::CopyRow(Connection& target) {
  const CopiedTable& table = kCopiedTables[table_];
  const std::int64_t source_key = columns_.front().is_key ? rows_->Integer(0) : 0;
  std::int64_t key = source_key;
  if (keys_ == Keys::kNew && columns_.front().is_key) {
    if (next_key_ == 0) {
      MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t last, target.QueryInteger(fmt::format(
                                                             "SELECT ifnull(max({}), 0) FROM {}",
                                                             columns_.front().name, table.name)));
      next_key_ = last + 1;
    }
    key = next_key_++;
    if (IsReferredTo(table.name)) target_keys_[table.name][source_key] = key;
  }
  if (table.name == "database") target_key_ = key;
  Statement insert = target.Query(insert_);
  std::int64_t bytes = 0;
  for (int c = 0; c < std::ssize(columns_); ++c) {
    MOTIONDB_RETURN_IF_ERROR(BindColumn(columns_[static_cast<std::size_t>(c)], c, key, insert));
    if (rows_->IsBlob(c)) bytes += std::ssize(rows_->Blob(c));
  }
  const absl::Status inserted = insert.Run();
  MOTIONDB_RETURN_IF_ERROR(table.name == kTextTable ? OfSearchIndex(inserted) : inserted);
  return bytes;
}

absl::Status DatabaseCopy::BindColumn(const Column& column, int index, std::int64_t key,
                                      Statement& insert) {
  if (keys_ == Keys::kSame) {
    insert.BindColumn(*rows_, index);
  } else if (column.is_key) {
    insert.Bind(key);
  } else if (!column.refers_to.empty() && !rows_->IsNull(index)) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t referred,
                              TargetKey(column.refers_to, rows_->Integer(index)));
    insert.Bind(referred);
  } else if (kCopiedTables[table_].name == "database" && column.name == "name") {
    insert.Bind(fmt::format("deleted/{}", key));
  } else if (kCopiedTables[table_].name == "database" && column.name == "deleted") {
    insert.Bind(1);
  } else {
    insert.BindColumn(*rows_, index);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> DatabaseCopy::TargetKey(std::string_view table,
                                                     std::int64_t key) const {
  const auto keys = target_keys_.find(table);
  if (keys != target_keys_.end()) {
    const auto found = keys->second.find(key);
    if (found != keys->second.end()) return found->second;
  }
  return core::DataLoss("table {}: row {} of table {} is missing", kCopiedTables[table_].name, key,
                        table);
}

}  // namespace motiondb::storage
