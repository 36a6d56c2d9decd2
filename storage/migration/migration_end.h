// The two stores of a migration, opened without a server: a file or a PostgreSQL database.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/store_lock.h"

namespace motiondb::storage {

// The table of a target whose migration is not complete: one row, the name of the source.
// PostgresMotionStore refuses a store that has it.
inline constexpr char kMigrationTable[] = "motiondb_migration";

class MigrationEnd {
 public:
  // Opens a store to read it. FAILED_PRECONDITION if a server uses it, or its version is not the
  // current one; the errors of the engines.
  static absl::StatusOr<MigrationEnd> OpenSource(const std::string& store);
  // Opens the store into which `source` is copied; creates its tables. A file gets another name
  // until Publish. FAILED_PRECONDITION if it has content, except that of an interrupted migration
  // from the same source, or a server uses it.
  static absl::StatusOr<MigrationEnd> OpenTarget(const std::string& store,
                                                 const MigrationEnd& source);

  Connection& connection() const { return *connection_; }
  // Path, or host, port and database: for messages, and to recognize the source.
  const std::string& name() const { return name_; }
  bool is_continued() const { return is_continued_; }

  // Makes a complete target a store that servers open. No other function may follow.
  absl::Status Publish();

 private:
  MigrationEnd() = default;
  static absl::StatusOr<MigrationEnd> OpenFileTarget(const std::string& store);
  static absl::StatusOr<MigrationEnd> OpenPostgres(const std::string& store);
  // Notes the source in an empty target; sets is_continued_.
  absl::Status Mark(const std::string& source);

  std::string name_;
  std::string file_;               // of a target while it is not complete; empty: in PostgreSQL
  std::optional<StoreLock> lock_;  // of a file
  std::unique_ptr<Connection> connection_;
  bool is_continued_ = false;
};

}  // namespace motiondb::storage
