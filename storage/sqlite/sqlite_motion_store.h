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
#include <type_traits>
#include <vector>

#include "core/motion/error.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/disk_reserve.h"
#include "storage/sqlite/file_identity.h"
#include "storage/sqlite/index_corruption.h"
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/staged_databases.h"
#include "storage/sqlite/store_lock.h"
#include "storage/sqlite/transaction.h"
#include "storage/sqlite/write_health.h"
#include "storage/sqlite/writer.h"

namespace motiondb::storage {

struct SqliteOptions {
  // Maximum number of concurrent reads; others wait.
  int reader_count = 4;
  // Clock for the time of models and edits: microseconds since the Unix epoch. Empty: system clock.
  // All other times come with the records.
  std::function<std::int64_t()> now_us;
  // Disk space that additions must leave free (disk_reserve.h); 0: no check. Ignored for a store in
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

class SqliteMotionStore final : public MotionStore,
                                public AnnotationStore,
                                public AccessStore,
                                public StoreMaintenance {
 public:
  // Opens the store at `path`. Creates it if the file is missing or empty; upgrades an older
  // version. ":memory:" is a store that ends with the object. FAILED_PRECONDITION, changing
  // nothing, if the file is not a store, has a newer version, or is open elsewhere.
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> Open(const std::string& path,
                                                                 SqliteOptions options = {});

  absl::Status CreateDatabase(const DatabaseRecord& record,
                              const WriteOptions& terms = {}) override;
  absl::StatusOr<DatabaseRecord> GetDatabase(const std::string& database) override;
  absl::StatusOr<std::vector<DatabaseRecord>> ListDatabases(const Page& page) override;
  absl::Status ReplaceMarkerSet(const std::string& database, const std::string& before,
                                const std::string& text, const WriteOptions& terms = {}) override;
  absl::Status DeleteDatabase(const std::string& database, const WriteOptions& terms = {}) override;
  absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) override;

  absl::StatusOr<ClipRecord> AddClip(const NewClip& clip) override;
  absl::StatusOr<ClipRecord> FindSameClip(const NewClip& clip) override;
  absl::StatusOr<ClipRecord> ReplaceClip(const ClipRecord& before, const NewClip& clip) override;
  absl::StatusOr<ClipRecord> GetClip(const std::string& database, const std::string& clip) override;
  absl::StatusOr<std::vector<ClipRecord>> ListClips(const std::string& database,
                                                    const Page& page) override;
  absl::StatusOr<ClipRecord> DeleteClip(const std::string& database, const std::string& clip,
                                        const WriteOptions& terms = {}) override;
  absl::StatusOr<ClipSource> ReadClipSource(const std::string& database,
                                            const std::string& clip) override;
  absl::StatusOr<core::StateSequence> ReadClipStates(const std::string& database,
                                                     const std::string& clip) override;

  absl::StatusOr<std::vector<ClipRecord>> PutDerived(const std::string& database,
                                                     std::span<const DerivedClip> clips) override;

  absl::StatusOr<core::Skeleton> GetSkeleton(const std::string& database,
                                             const std::string& skeleton) override;
  absl::StatusOr<std::vector<SkeletonRecord>> ListSkeletons(const std::string& database,
                                                            const Page& page) override;

  absl::StatusOr<ModelRecord> PutModel(const std::string& database,
                                       const core::Model& model) override;
  absl::StatusOr<ModelRecord> PutExtension(const std::string& database, const core::Model& model,
                                           double drift_fraction) override;
  absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                        const core::ParallelFor& parallel) override;
  absl::StatusOr<ModelStaleness> FindModelStaleness(const std::string& database) override;
  absl::StatusOr<ModelRecord> GetModel(const std::string& database, int version) override;
  absl::StatusOr<std::vector<ModelRecord>> ListModels(const std::string& database, int before,
                                                      int limit) override;
  absl::Status DropModel(const std::string& database) override;
  absl::Status PurgeDeletedClips(const std::string& database,
                                 const core::Cancelled& cancelled = {}) override;

  absl::Status PutOperation(const OperationRecord& record,
                            const core::Cancelled& cancelled = {}) override;
  absl::StatusOr<OperationRecord> GetOperation(const std::string& operation) override;
  absl::StatusOr<std::vector<OperationRecord>> ListOperations(const std::string& database,
                                                              const std::string& before,
                                                              int limit) override;

  absl::Status CheckWrites() override;
  WriteFailures write_failures() const override { return write_health_.failures(); }

  AnnotationStore& annotations() override { return *this; }
  absl::StatusOr<EditRecord> Edit(const std::string& database, std::span<const Change> changes,
                                  const std::string& author,
                                  const WriteOptions& terms = {}) override;
  absl::StatusOr<EditRecord> UndoEdit(const std::string& database, std::int64_t edit,
                                      const std::string& author,
                                      const WriteOptions& terms = {}) override;
  absl::StatusOr<std::vector<EditRecord>> ListEdits(const std::string& database,
                                                    const std::string& clip, std::int64_t before,
                                                    int limit) override;
  absl::StatusOr<SegmentRecord> GetSegment(const std::string& database, const std::string& clip,
                                           const std::string& segment) override;
  absl::StatusOr<std::vector<SegmentRecord>> ListSegments(const std::string& database,
                                                          const std::string& clip) override;
  absl::StatusOr<std::int64_t> Revision(const std::string& database) override;
  absl::StatusOr<std::vector<ChangeRecord>> Changes(const std::string& database, std::int64_t after,
                                                    int limit, std::int64_t begun = 0) override;
  absl::StatusOr<std::vector<TextMatch>> SearchClips(const std::string& database,
                                                     const std::string& query) override;

  AccessStore& access() override { return *this; }
  absl::Status AddToken(const TokenRecord& record, const WriteOptions& terms = {}) override;
  absl::StatusOr<TokenRecord> GetToken(const std::string& id) override;
  absl::StatusOr<std::vector<TokenRecord>> ListTokens(const std::string& after, int limit) override;
  absl::StatusOr<TokenRecord> RevokeToken(const std::string& id, std::int64_t time_us,
                                          const WriteOptions& terms = {}) override;
  absl::Status AddAuditRecord(const AuditRecord& record,
                              const core::Cancelled& cancelled = {}) override;
  absl::StatusOr<std::vector<AuditRecord>> ListAuditRecords(std::int64_t before,
                                                            int limit) override;

  StoreMaintenance& maintenance() override { return *this; }
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

  // Known bytes that a change adds; none: not an addition, so the reserve is not checked.
  using Added = std::optional<std::int64_t>;

  // Runs work(Connection&), which returns a Status or StatusOr, in a transaction, which is rolled
  // back on an error. Runs on the writer thread.
  template <typename Work>
  auto Transact(Connection& writer, Added added, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    MOTIONDB_RETURN_IF_ERROR(CheckMayWrite(writer, added));
    RepairSearchIndex(writer);
    auto result = InTransaction(writer, Transaction::Kind::kWrite, work);
    if (IsOfSearchIndex(StatusOf(result))) index_is_corrupt_ = true;
    return result;
  }
  // sqlite_motion_store_work.h defines the templates from here on.
  //
  // Queues Transact on the writer and waits for it. CANCELLED if cancelled before it began.
  template <typename Work>
  auto Write(Priority priority, const Work& work, const core::Cancelled& cancelled = {},
             Added added = {});
  // As Write, with an audit entry in the same transaction.
  template <typename Work>
  auto WriteWith(const WriteOptions& terms, const Work& work, Added added = {},
                 Priority priority = Priority::kOrdinary);
  // Runs work(Connection&, FreePolicy) with kFree, and on DATA_LOSS again with kLeave. Both may run
  // twice (WithSearchIndex).
  template <typename Work>
  auto WriteAndFree(const WriteOptions& terms, const Work& work, Added added = {});
  template <typename Work>
  auto Read(const Work& work);

  // Runs change(), and again if the corrupt search index prevented it: the second transaction first
  // rebuilds the index.
  template <typename Change>
  auto WithSearchIndex(const Change& change);
  // Rebuilds the search index, which is derived from the rows, if it was found to be corrupt. After
  // an error the next change that meets the corruption tries again. Runs on the writer thread.
  void RepairSearchIndex(Connection& writer);

  // Returns OK if the store's files are in place and, for an addition, the reserve stays free. If a
  // file is missing or replaced, moves the log into the store's file as far as possible, because
  // the log may be lost. Runs on the writer thread.
  absl::Status CheckMayWrite(Connection& writer, Added added);

  // Writes a page without changing it. CANCELLED if it waits longer than a second for other writes.
  absl::Status TryWriting();

  // Replaces the content of this store by the store of a checked backup.
  absl::Status ReplaceContent(Connection& backup, const core::Cancelled& cancelled);

  const std::string path_;  // empty for a store in memory
  const Files files_;       // the files that were opened
  const bool read_only_;
  const std::vector<Corruption> found_at_opening_;
  const DiskReserve reserve_;
  // Order of destruction: readers, then the writer, which empties the log, then the lock.
  std::optional<StoreLock> lock_;        // none for a store in memory
  std::unique_ptr<Writer> writer_;       // null if read-only
  std::unique_ptr<ReaderPool> readers_;  // null for a store in memory: the writer reads it
  const std::function<std::int64_t()> now_us_;
  const std::function<void(const absl::Status&)> on_index_rebuild_;
  WriteHealth write_health_;
  StagedDatabases staged_;
  std::atomic<bool> index_is_corrupt_ = false;  // the next change rebuilds the search index
  Mutex models_mutex_;                          // serializes PutModel and DropModel
};

}  // namespace motiondb::storage
