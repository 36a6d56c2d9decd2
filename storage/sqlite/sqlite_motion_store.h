// A store in one SQLite file, for one server. docs/storage_format.md describes the file.
//
// Thread-safe. Reads run beside each other and beside a write; each sees one moment. Writes run one
// after another, on the writer's thread (writer.h).
#pragma once

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
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/store_lock.h"
#include "storage/sqlite/transaction.h"
#include "storage/sqlite/write_health.h"
#include "storage/sqlite/writer.h"

namespace motiondb::storage {

struct SqliteOptions {
  // Most reads at a time; more wait.
  int reader_count = 4;
  // When a model is put: microseconds since the Unix epoch. The system's clock where empty. All
  // other times come with the records.
  std::function<std::int64_t()> now_us;
  // What additions leave free on the store's disk, so that it can be emptied; 0: they do not look.
  // Not for a store in memory.
  std::int64_t reserve_bytes = 0;
  // Every change is refused (FAILED_PRECONDITION) and no file of the store is written, so that they
  // may be on a read-only file system. The store has to be there, of the current version.
  bool read_only = false;
  // Name of a registered SQLite VFS; empty for the default one. Tests put faults there.
  std::string vfs;
};

class SqliteMotionStore final : public MotionStore, public AccessStore, public StoreUpkeep {
 public:
  // Opens the store at `path`, making it where there is none or an empty file, and upgrading one of
  // an older version. ":memory:" is a store that ends with the object. FAILED_PRECONDITION,
  // changing nothing, if the file is not a store, is of a newer version, or is open elsewhere.
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> Open(const std::string& path,
                                                                 SqliteOptions options = {});

  absl::Status CreateDatabase(const DatabaseRecord& record, const ChangeTerms& terms = {}) override;
  absl::StatusOr<DatabaseRecord> GetDatabase(const std::string& database) override;
  absl::StatusOr<std::vector<DatabaseRecord>> ListDatabases(const Page& page) override;
  absl::Status DeleteDatabase(const std::string& database, const ChangeTerms& terms = {}) override;
  absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) override;

  absl::StatusOr<ClipRecord> AddClip(const NewClip& clip) override;
  absl::StatusOr<ClipRecord> GetClip(const std::string& database, const std::string& clip) override;
  absl::StatusOr<std::vector<ClipRecord>> ListClips(const std::string& database,
                                                    const Page& page) override;
  absl::StatusOr<ClipRecord> DeleteClip(const std::string& database, const std::string& clip,
                                        const ChangeTerms& terms = {}) override;
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

  AccessStore& access() override { return *this; }
  absl::Status AddToken(const TokenRecord& record, const ChangeTerms& terms = {}) override;
  absl::StatusOr<TokenRecord> GetToken(const std::string& id) override;
  absl::StatusOr<std::vector<TokenRecord>> ListTokens(const std::string& after, int limit) override;
  absl::StatusOr<TokenRecord> RevokeToken(const std::string& id, std::int64_t time_us,
                                          const ChangeTerms& terms = {}) override;
  absl::Status AddAuditRecord(const AuditRecord& record,
                              const core::Cancelled& cancelled = {}) override;
  absl::StatusOr<std::vector<AuditRecord>> ListAuditRecords(std::int64_t before,
                                                            int limit) override;

  StoreUpkeep& upkeep() override { return *this; }
  absl::Status CheckIsWritable() const override;
  std::vector<Damage> FoundAtOpening() const override { return found_at_opening_; }
  absl::Status CheckFile() override;
  absl::StatusOr<std::unique_ptr<StoreVerifier>> BeginVerify(core::Cancelled cancelled) override;
  // Both FAILED_PRECONDITION for a store in memory.
  absl::StatusOr<std::unique_ptr<StoreBackup>> BeginBackup(
      const core::Cancelled& cancelled) override;
  absl::StatusOr<std::unique_ptr<StoreRestore>> BeginRestore() override;

 private:
  struct Files {
    FileIdentity store;
    FileIdentity log;  // not of a store that is open read-only
  };
  SqliteMotionStore(std::string path, Files files, std::optional<StoreLock> lock,
                    std::unique_ptr<Writer> writer, std::unique_ptr<ReaderPool> readers,
                    std::vector<Damage> found_at_opening, SqliteOptions options);
  // Both after the checks of Open; `file` is absolute.
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> OpenToWrite(std::string file,
                                                                        SqliteOptions options);
  static absl::StatusOr<std::unique_ptr<SqliteMotionStore>> OpenReadOnly(std::string file,
                                                                         SqliteOptions options);

  // The bytes that a change adds, as far as they are known; none: it is no addition, and need not
  // leave the reserve.
  using Added = std::optional<std::int64_t>;

  // Runs work(Connection&), which returns a Status or StatusOr, in a transaction: all of it
  // happens, or after an error none. On the writer's thread.
  template <typename Work>
  auto Transact(Connection& writer, Added added, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    MOTIONDB_RETURN_IF_ERROR(CheckMayWrite(writer, added));
    return InTransaction(writer, Transaction::Kind::kWrite, work);
  }
  // Has the writer do that. CANCELLED before its turn.
  template <typename Work>
  auto Write(Priority priority, const Work& work, const core::Cancelled& cancelled = {},
             Added added = {});
  // The same with an entry of the record of changes.
  template <typename Work>
  auto WriteWith(const ChangeTerms& terms, const Work& work, Added added = {},
                 Priority priority = Priority::kOrdinary);
  // Runs work(Connection&, Remains) so that what cannot be freed does not stop it.
  template <typename Work>
  auto WriteAndFree(const ChangeTerms& terms, const Work& work);
  template <typename Work>
  auto Read(const Work& work);

  // OK if a change that is committed now will last, and leaves the reserve if it is an addition.
  // Otherwise moves what the log holds into the store's file as far as it can, because the log may
  // be lost. On the writer's thread.
  absl::Status CheckMayWrite(Connection& writer, Added added);

  // Writes a page that stays as it is. CANCELLED if another write takes long.
  absl::Status TryWriting();

  // Makes the checked store of a backup this store's own.
  absl::Status TakeOver(Connection& backup, const core::Cancelled& cancelled);

  const std::string path_;  // empty for a store in memory
  const Files files_;       // that were opened under `path_`
  const bool read_only_;
  const std::vector<Damage> found_at_opening_;
  const DiskReserve reserve_;
  // Destroyed from last to first: readers, then the writer, which empties the log, then the lock.
  std::optional<StoreLock> lock_;        // none for a store in memory
  std::unique_ptr<Writer> writer_;       // null if read-only
  std::unique_ptr<ReaderPool> readers_;  // null for a store in memory, which the writer reads
  std::function<std::int64_t()> now_us_;
  WriteHealth write_health_;
  Mutex models_mutex_;  // models are put and dropped one at a time
};

}  // namespace motiondb::storage
