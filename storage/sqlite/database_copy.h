// Copies the rows of one database from one store to another: for its export and import.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sql/connection.h"

namespace motiondb::storage {

class DatabaseCopy {
 public:
  static constexpr std::int64_t kStepBytes = 4 << 20;

  // How keys change. kSame, into a store without databases: rows keep their keys and checksums, so
  // that a later verification finds a row that was corrupt in the source. kNew: rows get free keys
  // and new checksums, and the database is hidden like a deleted one.
  enum class Keys { kSame, kNew };

  // `source` must outlive the object and must not change meanwhile. Copies neither operations nor
  // rows that a purge would free. With kSame, FillClipText must follow.
  DatabaseCopy(Connection& source, std::int64_t database_key, Keys keys);

  // Copies the next rows, about kStepBytes at most, in the caller's write transaction on `target`.
  // Returns false after the last row. After an error the object must not be used. DATA_LOSS if a
  // row cannot be read or refers to a missing one.
  absl::StatusOr<bool> Step(Connection& target);

  // Key of the database in the target; 0 before the first step.
  std::int64_t target_key() const { return target_key_; }

 private:
  struct Column {
    std::string name;
    std::string refers_to;  // the table whose key it contains; empty: none
    bool is_key = false;    // of the row itself
  };

  // Begins to read table number `table_`.
  void BeginTable();
  // Copies the current row of `rows_`. Returns the bytes of its blobs.
  absl::StatusOr<std::int64_t> CopyRow(Connection& target);
  absl::Status BindColumn(const Column& column, int index, std::int64_t key, Statement& insert);
  // Returns the key in the target of a row of `table`.
  absl::StatusOr<std::int64_t> TargetKey(std::string_view table, std::int64_t key) const;

  Connection& source_;
  const std::int64_t database_key_;
  const Keys keys_;
  std::int64_t target_key_ = 0;
  std::size_t table_ = 0;
  std::vector<Column> columns_;    // of the table
  std::string insert_;             // SQL
  std::int64_t next_key_ = 0;      // kNew: of the next row in the target; valid in one transaction
  std::optional<Statement> rows_;  // of the table; none: it is not begun
  // kNew: key in the target by key in the source, of the tables that others refer to.
  std::unordered_map<std::string_view, std::unordered_map<std::int64_t, std::int64_t>> target_keys_;
};

}  // namespace motiondb::storage
