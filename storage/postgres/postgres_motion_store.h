// A store in a PostgreSQL database, which several servers may share. docs/storage_format.md
// describes the tables, which are those of SQLite.
//
// Writes of this process run one after another on one session (writer.h); those of other processes
// run between them. A write locks the row of its database first, so the changes of one database
// have an order, which is that of their revisions.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/postgres/postgres_connector.h"
#include "storage/postgres/schema.h"
#include "storage/sql/sql_motion_store.h"
#include "storage/sqlite/store_disk.h"

namespace motiondb::storage {

struct PostgresOptions {
  // Maximum number of concurrent reads, each with a session of its own; others wait. The store has
  // one session more, which writes.
  int reader_count = 4;
  // Clock for the time of models and edits: microseconds since the Unix epoch. Empty: system clock.
  std::function<std::int64_t()> now_us;
  // Changes return FAILED_PRECONDITION. The store must have the current version.
  bool read_only = false;
};

class PostgresMotionStore final : public SqlMotionStore {
 public:
  // Creates the tables if there are none; upgrades an older version. INVALID_ARGUMENT: not a URL;
  // UNAVAILABLE: PostgreSQL cannot be reached; FAILED_PRECONDITION: it refuses the role, password
  // or database, see MigratePostgres, or an unsupported version of PostgreSQL.
  static absl::StatusOr<std::unique_ptr<PostgresMotionStore>> Open(const std::string& url,
                                                                   PostgresOptions options = {});
  ~PostgresMotionStore() override { CloseConnections(); }

  bool is_shared() const override { return true; }
  // Returns OK unless the last write, or a write for lack of space, failed and a test write of the
  // size of a small clip fails too.
  absl::Status CheckWrites() override;
  ConnectionStatistics connections() const override;
  absl::StatusOr<std::vector<TextMatch>> SearchClips(const std::string& database,
                                                     const std::string& query) override;

  absl::Status AnnounceServer(const ServerAddress& server,
                              std::chrono::milliseconds duration) override;
  absl::StatusOr<std::vector<ServerAddress>> ListServers() override;
  // Null with a pooler.
  std::unique_ptr<StoreWatch> WatchChanges(OnStoreChange on_change) override;

  absl::Status CheckIsWritable() const override;
  std::vector<Corruption> FoundAtOpening() const override { return {}; }
  // There is no file.
  absl::Status CheckFile() override { return absl::OkStatus(); }
  absl::StatusOr<std::unique_ptr<StoreVerifier>> BeginVerify(core::Cancelled cancelled) override;
  // A backup is the file of an SQLite store, which either kind of store restores. Copies are in a
  // folder for temporary files (TMPDIR).
  absl::StatusOr<std::unique_ptr<StoreBackup>> BeginBackup(
      const core::Cancelled& cancelled) override;
  absl::StatusOr<std::unique_ptr<StoreRestore>> BeginRestore() override;
  absl::StatusOr<std::unique_ptr<StoreBackup>> BeginExport(
      const std::string& database, const core::Cancelled& cancelled) override;
  absl::StatusOr<std::unique_ptr<DatabaseImport>> BeginImport() override;

  // The versions of the tables before and after Open; equal if read-only.
  const SchemaVersions& versions() const { return versions_; }
  // Host, port and database, for messages.
  const std::string& name() const { return connector_->address().name; }

 private:
  PostgresMotionStore(std::shared_ptr<PostgresConnector> connector, SchemaVersions versions,
                      std::unique_ptr<Writer> writer, std::unique_ptr<ReaderPool> readers,
                      const PostgresOptions& options);

  absl::Status CheckMayWrite(Connection&, Added) override { return absl::OkStatus(); }
  bool checks_room() const override { return false; }
  // By PostgreSQL's clock, which all servers share.
  absl::StatusOr<std::int64_t> LeaseTimeUs(Connection& connection) override;
  absl::Status TryWriting();
  // Replaces the content of this store by the store of a checked backup.
  absl::Status ReplaceContent(Connection& backup, const core::Cancelled& cancelled);

  const std::shared_ptr<PostgresConnector> connector_;
  const SchemaVersions versions_;
  const bool read_only_;
  // Failures for lack of space after which a test write has succeeded.
  std::atomic<std::int64_t> tried_no_space_ = 0;
  CopyFolder copies_;
};

}  // namespace motiondb::storage
