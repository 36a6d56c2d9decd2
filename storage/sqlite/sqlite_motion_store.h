// A store in one SQLite file, for one server. docs/storage_format.md describes the file.
//
// Reads run concurrently with each other and with a write; each sees a consistent snapshot. Writes
// run one after another on the writer thread (writer.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "storage/motion_store.h"
#include "storage/sql/sql_motion_store.h"
#include "storage/sqlite/store_disk.h"
#include "storage/sqlite/store_lock.h"

namespace motiondb::storage {

struct SqliteOptions {
  // Maximum number of concurrent reads; others wait.
  int reader_count = 4;
  // Clock for the time of models and edits: microseconds since the Unix epoch. Empty: system clock.
  // All other times come with the records.
  std::function<std::int64_t()> now_us;
  // Disk space that additions must leave free (DiskReserve); 0: no check. Ignored for a store in
  // memory.
  std::int64_t reserve_bytes = 0;
  // Changes return FAILED_PRECONDITION, and no file of the store is written: the file system may be
  // read-only. The store must exist and have the current version.
  bool read_only = false;
  // Called on the writer thread after the corrupt search index was rebuilt from the clips (OK) or
  // could not be rebuilt. May be empty; must not call the store.
  std::function<void(const absl::Status&)> on_index_rebuild;
  // Name of a registered SQLite VFS; empty for the default. Tests inject faults with it.
  std::string vfs;
};

class SqliteMotionStore final : public SqlMotionStore {
 public:
  // Opens the store at `path`. Creates it if the file is missing or empty; upgrades an older
  // version. ":memory:" is a store that ends with the object. FAILED_PRECONDITION, changing
  // nothing, if the file is not a store, has a newer version, or is open elsewhere.
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> Open(const std::string& path,
                                                                 SqliteOptions options = {});
  // Closes the connections before it gives up the lock.
  ~SqliteMotionStore() override { CloseConnections(); }

  absl::Status CheckWrites() override;
  absl::StatusOr<std::vector<TextMatch>> SearchClips(const std::string& database,
                                                     const std::string& query) override;

  absl::Status CheckIsWritable() const override;
  std::vector<Corruption> FoundAtOpening() const override { return found_at_opening_; }
  absl::Status CheckFile() override;
  absl::StatusOr<std::unique_ptr<StoreVerifier>> BeginVerify(core::Cancelled cancelled) override;
  // The following return FAILED_PRECONDITION for a store in memory.
  absl::StatusOr<std::unique_ptr<StoreBackup>> BeginBackup(
      const core::Cancelled& cancelled) override;
  absl::StatusOr<std::unique_ptr<StoreRestore>> BeginRestore() override;
  absl::StatusOr<std::unique_ptr<StoreBackup>> BeginExport(
      const std::string& database, const core::Cancelled& cancelled) override;
  absl::StatusOr<std::unique_ptr<DatabaseImport>> BeginImport() override;

 private:
  struct Files {
    FileIdentity store;
    FileIdentity log;  // unset if read-only
  };
  SqliteMotionStore(std::string path, Files files, std::optional<StoreLock> lock,
                    std::unique_ptr<Writer> writer, std::unique_ptr<ReaderPool> readers,
                    std::vector<Corruption> found_at_opening, SqliteOptions options);
  // Open without its checks; `file` is absolute.
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> OpenToWrite(std::string file,
                                                                        SqliteOptions options);
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> OpenReadOnly(std::string file,
                                                                         SqliteOptions options);

  // Returns OK if the store's files are in place and, for an addition, the reserve stays free. If a
  // file is missing or replaced, moves the log into the store's file as far as possible, because
  // the log may be lost. Rebuilds the search index, which is derived from the rows, if it was found
  // to be corrupt; after an error the next change that meets the corruption tries again.
  absl::Status CheckMayWrite(Connection& writer, Added added) override;
  bool MayRepair(const absl::Status& error) override;
  bool checks_room() const override { return !reserve_.is_off(); }

  // Writes a page without changing it. CANCELLED if it waits longer than a second for other writes.
  absl::Status TryWriting();

  // Replaces the content of this store by the store of a checked backup.
  absl::Status ReplaceContent(Connection& backup, const core::Cancelled& cancelled);

  const std::string path_;  // empty for a store in memory
  const Files files_;       // the files that were opened
  const bool read_only_;
  const std::vector<Corruption> found_at_opening_;
  const DiskReserve reserve_;
  std::optional<StoreLock> lock_;  // none for a store in memory; outlives the writer
  const std::function<void(const absl::Status&)> on_index_rebuild_;
  std::atomic<bool> index_is_corrupt_ = false;  // the next change rebuilds the search index
};

}  // namespace motiondb::storage
