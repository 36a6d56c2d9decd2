#include "storage/sql/tables/row_copy.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "storage/sql/tables/clip_text.h"

namespace motiondb::storage {
namespace {

constexpr int kStepRows = 256;  // at most, in one step
constexpr int kFreeKeys = 64;   // asked for at a time
constexpr char kInvalidChecksum[] = "-1";
constexpr std::string_view kSequence = "sequence";  // key of operations, tokens and audit entries
constexpr std::string_view kDeletedPrefix = "deleted/";  // see MarkDatabaseDeleted

std::vector<CopiedTable> TablesOf(std::optional<std::int64_t> database_key, RowCopy::Mode mode) {
  // A backup makes the texts again, so that a corrupt search index does not prevent it.
  return database_key ? TablesOfDatabase(mode == RowCopy::Mode::kImport) : TablesOfStore();
}

// Returns "(?2, ?3)" for two keys from number 2.
std::string Parameters(std::size_t first, std::size_t count) {
  std::string parameters;
  for (std::size_t i = first; i < first + count; ++i) {
    parameters += fmt::format("{}?{}", parameters.empty() ? "" : ", ", i);
  }
  return parameters;
}

}  // namespace

RowCopy::RowCopy(Connection& source, std::optional<std::int64_t> database_key, Mode mode)
    : source_(source),
      database_key_(database_key),
      mode_(mode),
      tables_(TablesOf(database_key, mode)) {}

absl::Status RowCopy::Continue(Connection& target) {
  for (std::size_t t = tables_.size(); t-- > 0;) {
    const CopiedTable& table = tables_[t];
    const std::string keys(table.keys);
    const bool two = !table.has_own_key();
    Statement last =
        target.Query(fmt::format("SELECT {} FROM {} ORDER BY {} DESC LIMIT 1", keys, table.name,
                                 two ? fmt::format("{} DESC, {}", keys.substr(0, keys.find(',')),
                                                   keys.substr(keys.find(' ') + 1))
                                     : keys));
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, last.Step());
    if (!found) continue;
    table_ = t;
    after_ = {last.Integer(0)};
    if (two) after_.push_back(last.Integer(1));
    return absl::OkStatus();
  }
  return absl::OkStatus();
}

absl::StatusOr<bool> RowCopy::Step(Connection& target) {
  free_keys_.clear();
  std::int64_t bytes = 0;
  for (int rows = 0; rows < kStepRows && bytes < kStepBytes;) {
    if (table_ == tables_.size()) return false;
    if (!rows_) BeginTable(target);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, rows_->Step());
    if (found) {
      MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t copied, CopyRow(target));
      bytes += copied;
      copied_bytes_ += copied;
      ++rows;
      continue;
    }
    rows_.reset();
    after_.clear();
    free_keys_.clear();
    ++table_;
  }
  return true;
}

absl::Status RowCopy::Finish(Connection& target) {
  for (const CopiedTable& table : tables_) {
    if (table.has_own_key()) {
      MOTIONDB_RETURN_IF_ERROR(target.SkipUsedKeys(table.name, table.keys));
    }
  }
  return FillClipText(target);
}

void RowCopy::BeginTable(const Connection& target) {
  const CopiedTable& table = tables_[table_];
  columns_ = ColumnsOf(table);
  std::string select = ColumnNames(table);
  if (table.has_checksum()) select += ", " + source_.RowIsChanged(table.name);
  std::string condition = table.condition;
  if (!after_.empty()) {
    condition += fmt::format(" AND ({}) > ({})", table.keys, Parameters(1, after_.size()));
  }
  insert_ = InsertOf(target.ChecksumOf(Parameters(1, columns_.size())));
  const std::string order = table.in_order ? fmt::format(" ORDER BY {}", table.keys) : "";
  rows_.emplace(source_.Stream(
      fmt::format("SELECT {} FROM {} WHERE {}{}", select, table.name, condition, order)));
  if (database_key_) rows_->Bind(*database_key_);
  for (const std::int64_t key : after_) rows_->Bind(key);
}

std::string RowCopy::InsertOf(const std::string& checksum) const {
  const CopiedTable& table = tables_[table_];
  std::string into = ColumnNames(table);
  std::string values = Parameters(1, columns_.size());
  if (table.has_checksum()) {
    into += ", row_crc";
    values += ", " + checksum;
  }
  return fmt::format("INSERT INTO {} ({}) VALUES ({})", table.name, into, values);
}

absl::StatusOr<std::int64_t> RowCopy::CopyRow(Connection& target) {
  const CopiedTable& table = tables_[table_];
  const auto count = static_cast<int>(columns_.size());
  const bool is_corrupt = table.has_checksum() && rows_->Integer(count) != 0;
  if (is_corrupt && mode_ != Mode::kBackup) {
    return core::DataLoss("row {} of table {}: its checksum does not match", rows_->Integer(0),
                          table.name);
  }
  std::int64_t key = rows_->Integer(0);
  if (has_new_keys() && columns_.front().is_key && table.keys != kSequence) {
    MOTIONDB_ASSIGN_OR_RETURN(key, FreeKey(target));
    if (table.is_parent) target_keys_[table.name][rows_->Integer(0)] = key;
  }
  if (table.name == "database") target_key_ = key;

  Statement insert = target.Query(is_corrupt ? InsertOf(kInvalidChecksum) : insert_);
  std::int64_t bytes = 0;
  for (int c = 0; c < count; ++c) {
    MOTIONDB_RETURN_IF_ERROR(BindColumn(columns_[static_cast<std::size_t>(c)], c, key, insert));
    if (rows_->IsBlob(c)) bytes += std::ssize(rows_->Blob(c));
  }
  const absl::Status inserted = insert.RunLater();
  MOTIONDB_RETURN_IF_ERROR(table.name == TextTable().name ? target.OfTexts(inserted) : inserted);
  return bytes;
}

absl::Status RowCopy::BindColumn(const CopiedColumn& column, int index, std::int64_t key,
                                 Statement& insert) {
  const bool is_of_database = has_new_keys() && tables_[table_].name == "database";
  const auto is_name_of_deleted = [&] {
    return mode_ == Mode::kImport || rows_->Text(index).starts_with(kDeletedPrefix);
  };
  if (column.is_key) {
    insert.Bind(key);
  } else if (has_new_keys() && !column.refers_to.empty() && !rows_->IsNull(index)) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t referred,
                              TargetKey(column.refers_to, rows_->Integer(index)));
    insert.Bind(referred);
  } else if (is_of_database && column.name == "name" && is_name_of_deleted()) {
    insert.Bind(fmt::format("{}{}", kDeletedPrefix, key));
  } else if (is_of_database && column.name == "deleted" && mode_ == Mode::kImport) {
    insert.Bind(1);
  } else {
    insert.BindColumn(*rows_, index);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> RowCopy::FreeKey(Connection& target) {
  const CopiedTable& table = tables_[table_];
  if (free_keys_.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(free_keys_, target.FreeKeys(table.name, table.keys, kFreeKeys));
    std::ranges::reverse(free_keys_);
  }
  const std::int64_t key = free_keys_.back();
  free_keys_.pop_back();
  return key;
}

absl::StatusOr<std::int64_t> RowCopy::TargetKey(std::string_view table, std::int64_t key) const {
  const auto keys = target_keys_.find(table);
  if (keys != target_keys_.end()) {
    const auto found = keys->second.find(key);
    if (found != keys->second.end()) return found->second;
  }
  return core::DataLoss("table {}: row {} of table {} is missing", tables_[table_].name, key,
                        table);
}

}  // namespace motiondb::storage
