// PostgresMotionStore: backup, restore, export and import, whose files are SQLite stores.
#include <algorithm>
#include <string>
#include <vector>

#include "core/motion/error.h"
#include "storage/postgres/postgres_connection.h"
#include "storage/postgres/postgres_motion_store.h"
#include "storage/sql/sql_motion_store_work.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/row_copy.h"
#include "storage/sql/tables/table_lists.h"
#include "storage/sqlite/sqlite_backup.h"
#include "storage/sqlite/sqlite_restore.h"
#include "storage/sqlite/store_disk.h"

namespace motiondb::storage {
namespace {

// Temporary files have a disk of their own, which need not keep anything free.
DiskReserve NoReserve(const std::string& path) { return {path, 0}; }

// Deletes all rows, those first that refer to others.
absl::Status DeleteAllRows(Connection& connection) {
  std::vector<CopiedTable> tables = TablesOfStore();
  tables.push_back(TextTable());
  std::ranges::reverse(tables);
  for (const CopiedTable& table : tables) {
    MOTIONDB_RETURN_IF_ERROR(connection.Query(fmt::format("DELETE FROM {}", table.name)).Run());
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<StoreBackup>> PostgresMotionStore::BeginBackup(
    const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string path, copies_.StorePath());
  return Read([&](Connection& reader) -> absl::StatusOr<std::unique_ptr<StoreBackup>> {
    return SqliteBackup::MakeOfRows(reader, path, cancelled);
  });
}

absl::StatusOr<std::unique_ptr<StoreRestore>> PostgresMotionStore::BeginRestore() {
  MOTIONDB_RETURN_IF_ERROR(CheckIsWritable());
  MOTIONDB_RETURN_IF_ERROR(Read([](Connection& reader) { return CheckHasNoDatabases(reader); }));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string path, copies_.StorePath());
  return SqliteRestore::Make(path, NoReserve(path),
                             [this](Connection& backup, const core::Cancelled& cancelled) {
                               return ReplaceContent(backup, cancelled);
                             });
}

absl::StatusOr<std::unique_ptr<StoreBackup>> PostgresMotionStore::BeginExport(
    const std::string& database, const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string path, copies_.StorePath());
  return Read([&](Connection& reader) -> absl::StatusOr<std::unique_ptr<StoreBackup>> {
    return SqliteBackup::MakeExport(reader, database, path, NoReserve(path), cancelled);
  });
}

absl::StatusOr<std::unique_ptr<DatabaseImport>> PostgresMotionStore::BeginImport() {
  MOTIONDB_RETURN_IF_ERROR(CheckIsWritable());
  MOTIONDB_ASSIGN_OR_RETURN(const std::string path, copies_.StorePath());
  return SqliteImport::Make(path, NoReserve(path), staged(),
                            [this](Priority priority, const WriteOptions& terms,
                                   std::int64_t added_bytes, const SqliteImport::Piece& piece) {
                              return WriteWith(terms, piece, Added(added_bytes), priority);
                            });
}

absl::Status PostgresMotionStore::ReplaceContent(Connection& backup,
                                                 const core::Cancelled& cancelled) {
  return writer()->Run(Priority::kOrdinary, cancelled, [&](Connection& writer) -> absl::Status {
    // Not InTransaction, which may run it twice: the copy cannot begin again.
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                              Transaction::Begin(writer, Transaction::Kind::kWrite));
    // Other servers read meanwhile, and add nothing.
    MOTIONDB_RETURN_IF_ERROR(
        writer.Execute("LOCK TABLE database, token, audit IN SHARE ROW EXCLUSIVE MODE"));
    MOTIONDB_RETURN_IF_ERROR(CheckHasNoDatabases(writer));
    // Of any server.
    MOTIONDB_ASSIGN_OR_RETURN(const bool has_hidden, HasHidden(writer));
    if (has_hidden || !staged().IsEmpty()) {
      return core::FailedPrecondition(
          "a database is being imported: restore a backup into an empty store");
    }
    MOTIONDB_RETURN_IF_ERROR(CopyAccessRecords(writer, backup));
    MOTIONDB_RETURN_IF_ERROR(DeleteAllRows(writer));
    RowCopy rows(backup, std::nullopt, RowCopy::Mode::kRestore);
    for (bool more = true; more;) {
      if (cancelled && cancelled()) {
        return absl::CancelledError("cancelled while the backup was restored");
      }
      MOTIONDB_ASSIGN_OR_RETURN(more, rows.Step(writer));
    }
    MOTIONDB_RETURN_IF_ERROR(rows.Finish(writer));
    return transaction.Commit();
  });
}

}  // namespace motiondb::storage
