// The part of a store that SQLite and PostgreSQL share: databases, clips, models, operations,
// annotations, tokens and the audit log, on the tables of storage/sql. An engine derives from it
// and adds the search of texts, the maintenance, and what must be checked before a change.
//
// Reads run concurrently with each other and with a write; each sees a consistent snapshot. Writes
// run one after another on the writer thread (writer.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/connection/reader_pool.h"
#include "storage/sql/connection/write_health.h"
#include "storage/sql/connection/writer.h"
#include "storage/sql/tables/deleted_databases.h"

namespace motiondb::storage {

class SqlMotionStore : public MotionStore,
                       public AnnotationStore,
                       public AccessStore,
                       public StoreMaintenance {
 public:
  absl::Status CreateDatabase(const DatabaseRecord& record,
                              const WriteOptions& terms = {}) override;
  absl::StatusOr<DatabaseRecord> GetDatabase(const std::string& database) override;
  absl::StatusOr<std::vector<DatabaseRecord>> ListDatabases(const Page& page) override;
  absl::Status ReplaceMarkerSet(const std::string& database, const std::string& before,
                                const std::string& text, const WriteOptions& terms = {}) override;
  absl::Status DeleteDatabase(const std::string& database, const WriteOptions& terms = {}) override;
  absl::StatusOr<std::vector<DatabaseState>> ListDatabaseStates() override;
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
                                                     std::span<const DerivedClip> clips,
                                                     std::int64_t fence = 0) override;

  absl::StatusOr<core::Skeleton> GetSkeleton(const std::string& database,
                                             const std::string& skeleton) override;
  absl::StatusOr<std::vector<SkeletonRecord>> ListSkeletons(const std::string& database,
                                                            const Page& page) override;

  absl::StatusOr<ModelRecord> PutModel(const std::string& database, const core::Model& model,
                                       const ModelTerms& terms = {}) override;
  absl::StatusOr<ModelRecord> PutExtension(const std::string& database, const core::Model& model,
                                           double drift_fraction,
                                           const ModelTerms& terms = {}) override;
  absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                        const core::ParallelFor& parallel) override;
  absl::StatusOr<core::Model> ReadExtension(const std::string& database, std::int32_t base_version,
                                            const core::Model& base,
                                            const core::ParallelFor& parallel) override;
  absl::StatusOr<ModelStaleness> FindModelStaleness(const std::string& database) override;
  absl::StatusOr<ModelRecord> GetModel(const std::string& database, int version) override;
  absl::StatusOr<std::vector<ModelRecord>> ListModels(const std::string& database, int before,
                                                      int limit) override;
  absl::Status DropModel(const std::string& database, const ModelTerms& terms = {}) override;
  absl::Status PurgeDeletedClips(const std::string& database,
                                 const core::Cancelled& cancelled = {}) override;

  absl::StatusOr<std::int64_t> AcquireBuildLease(const std::string& database,
                                                 const std::string& holder,
                                                 std::chrono::milliseconds duration) override;
  absl::Status RenewBuildLease(const std::string& database, std::int64_t fence,
                               std::chrono::milliseconds duration) override;
  absl::Status ReleaseBuildLease(const std::string& database, std::int64_t fence) override;

  absl::Status PutOperation(const OperationRecord& record,
                            const core::Cancelled& cancelled = {}) override;
  absl::StatusOr<OperationRecord> GetOperation(const std::string& operation) override;
  absl::StatusOr<std::vector<OperationRecord>> ListOperations(const std::string& database,
                                                              const std::string& before,
                                                              int limit) override;
  absl::StatusOr<std::vector<OperationRecord>> ListUnfinishedOperations() override;

  WriteFailures write_failures() const override { return write_health_.failures(); }
  ConnectionStatistics connections() const override {
    return readers_ == nullptr ? ConnectionStatistics() : readers_->statistics();
  }

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

 protected:
  // Known bytes that a change adds; none: not an addition.
  using Added = std::optional<std::int64_t>;

  // `writer`: null if the store is read-only. `readers`: null if the writer reads. `now_us`: clock
  // for the time of models and edits, microseconds since the Unix epoch; empty: system clock.
  SqlMotionStore(std::unique_ptr<Writer> writer, std::unique_ptr<ReaderPool> readers,
                 std::function<std::int64_t()> now_us);

  // Returns OK if the store can take a change. Runs on the writer thread, before each transaction.
  virtual absl::Status CheckMayWrite(Connection& writer, Added added) = 0;
  // Returns whether to run a transaction that failed with `error` a second time: CheckMayWrite then
  // repairs what the error is about.
  virtual bool MayRepair(const absl::Status&) { return false; }
  // Returns the time for build leases, microseconds since the Unix epoch, on a writing connection.
  virtual absl::StatusOr<std::int64_t> LeaseTimeUs(Connection&) { return now_us_(); }
  // Returns whether CheckMayWrite uses the size of additions.
  virtual bool checks_room() const = 0;

  // Runs work(Connection&), which returns a Status or StatusOr, in a transaction, which is rolled
  // back on an error; a second time after a repair. Runs on the writer thread.
  template <typename Work>
  auto Transact(Connection& writer, Added added, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    for (bool is_repaired = false;; is_repaired = true) {
      MOTIONDB_RETURN_IF_ERROR(CheckMayWrite(writer, added));
      auto result = InTransaction(writer, Transaction::Kind::kWrite, work);
      if (is_repaired || StatusOf(result).ok() || !MayRepair(StatusOf(result))) return result;
    }
  }
  // sql_motion_store_work.h defines the templates from here on.
  //
  // Queues Transact on the writer and waits for it. CANCELLED if cancelled before it began.
  template <typename Work>
  auto Write(Priority priority, const Work& work, const core::Cancelled& cancelled = {},
             Added added = {});
  // As Write, with an audit entry in the same transaction.
  template <typename Work>
  auto WriteWith(const WriteOptions& terms, const Work& work, Added added = {},
                 Priority priority = Priority::kOrdinary);
  // Runs work(Connection&, FreePolicy) with kFree, and on DATA_LOSS again with kLeave.
  template <typename Work>
  auto WriteAndFree(const WriteOptions& terms, const Work& work, Added added = {});
  template <typename Work>
  auto Read(const Work& work);

  // Closes the connections: the readers, then the writer, which runs what is queued. An engine
  // whose members must outlive them calls it in its destructor.
  void CloseConnections();

  Writer* writer() { return writer_.get(); }
  WriteHealth& write_health() { return write_health_; }
  StagedDatabases& staged() { return staged_; }
  std::int64_t now_us() const { return now_us_(); }

 private:
  // Order of destruction: readers, then the writer.
  std::unique_ptr<Writer> writer_;
  std::unique_ptr<ReaderPool> readers_;
  std::function<std::int64_t()> now_us_;
  WriteHealth write_health_;
  StagedDatabases staged_;
  Mutex models_mutex_;  // serializes PutModel and DropModel
};

}  // namespace motiondb::storage
