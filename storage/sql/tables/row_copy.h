// Copies rows from one store to another, also between engines: of one database, for its export and
// import, or of the whole store, for a backup, a restore and a migration.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/table_lists.h"

namespace motiondb::storage {

class RowCopy {
 public:
  static constexpr std::int64_t kStepBytes = 4 << 20;

  enum class Mode {
    // Into a store without databases. Rows keep their keys. A row that is corrupt in the source
    // gets an invalid checksum, so that a verification of the target finds it.
    kBackup,
    // Into a store without rows. Rows keep their keys.
    kMove,
    // Like kMove, but into a store that other servers have open: databases and their rows get keys
    // that it never had. So no server and no build lease takes a database for a deleted one, and a
    // server that frees a deleted one takes no row for one of it.
    kRestore,
    // Of one database: its rows get free keys, and it is hidden like a deleted one.
    kImport,
  };

  // Copies the database `database_key`, without its operations and rows that a purge would free;
  // none: the whole store. `source` must outlive the object and must not change meanwhile: it is in
  // a read transaction or has no other user. No other statement may run on it before the last step.
  RowCopy(Connection& source, std::optional<std::int64_t> database_key, Mode mode);

  // Continues an interrupted copy of the whole store into `target`, which has its first rows, in
  // order. Before the first step; in the caller's transaction.
  absl::Status Continue(Connection& target);
  // Copies the next rows, about kStepBytes at most, in the caller's write transaction on `target`.
  // Returns false after the last row. After an error the object must not be used. DATA_LOSS if a
  // row cannot be read or refers to a missing one, or, except in a backup, is corrupt.
  absl::StatusOr<bool> Step(Connection& target);
  // After the last step, except in an import: fills the empty search index, and lets new rows get
  // keys above those of the copied ones. In the caller's write transaction.
  absl::Status Finish(Connection& target);

  std::int64_t copied_bytes() const { return copied_bytes_; }  // of blobs
  // Key of the database in the target; 0 before the first step.
  std::int64_t target_key() const { return target_key_; }

 private:
  // Begins to read table number `table_`, for `target`.
  void BeginTable(const Connection& target);
  std::string InsertOf(const std::string& checksum) const;
  // Copies the current row of `rows_`. Returns the bytes of its blobs.
  absl::StatusOr<std::int64_t> CopyRow(Connection& target);
  // Returns whether rows of databases get new keys. Others have a `sequence` in all modes.
  bool has_new_keys() const { return mode_ == Mode::kImport || mode_ == Mode::kRestore; }
  absl::Status BindColumn(const CopiedColumn& column, int index, std::int64_t key,
                          Statement& insert);
  // Returns a free key of the table for a new row.
  absl::StatusOr<std::int64_t> FreeKey(Connection& target);
  // Returns the key in the target of a row of `table`.
  absl::StatusOr<std::int64_t> TargetKey(std::string_view table, std::int64_t key) const;

  Connection& source_;
  const std::optional<std::int64_t> database_key_;
  const Mode mode_;
  const std::vector<CopiedTable> tables_;
  std::int64_t target_key_ = 0;
  std::int64_t copied_bytes_ = 0;
  std::size_t table_ = 0;
  std::vector<CopiedColumn> columns_;    // of the table
  std::string insert_;                   // SQL
  std::vector<std::int64_t> after_;      // key of the last row of the table that the target has
  std::vector<std::int64_t> free_keys_;  // valid in one transaction; the next is the last
  std::optional<Statement> rows_;        // of the table; none: it is not begun
  // Key in the target by key in the source, of the tables with new keys that others refer to.
  std::unordered_map<std::string_view, std::unordered_map<std::int64_t, std::int64_t>> target_keys_;
};

}  // namespace motiondb::storage
