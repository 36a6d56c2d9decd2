// A MotionStore in plain containers. It shows that the conformance suite tests the interface and
// not SQLite, and serves tests that need a store but no file.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/model/model.h"
#include "storage/edit_plan.h"
#include "storage/motion_store.h"
#include "tests/storage/conformance/in_memory_access_store.h"

namespace motiondb::tests {

class InMemoryMotionStore;

// Maintenance of a store in memory: only export and import. The bytes of an export are the name of
// the database in a list that all these stores share.
class InMemoryMaintenance final : public storage::StoreMaintenance {
 public:
  explicit InMemoryMaintenance(InMemoryMotionStore& store) : store_(store) {}
  absl::Status CheckIsWritable() const override { return absl::OkStatus(); }
  std::vector<storage::Corruption> FoundAtOpening() const override { return {}; }
  absl::Status CheckFile() override { return absl::OkStatus(); }
  absl::StatusOr<std::unique_ptr<storage::StoreVerifier>> BeginVerify(core::Cancelled) override {
    return absl::UnimplementedError("kept in memory");
  }
  absl::StatusOr<std::unique_ptr<storage::StoreBackup>> BeginBackup(
      const core::Cancelled&) override {
    return absl::UnimplementedError("kept in memory");
  }
  absl::StatusOr<std::unique_ptr<storage::StoreRestore>> BeginRestore() override {
    return absl::UnimplementedError("kept in memory");
  }
  absl::StatusOr<std::unique_ptr<storage::StoreBackup>> BeginExport(
      const std::string& database, const core::Cancelled& cancelled) override;
  absl::StatusOr<std::unique_ptr<storage::DatabaseImport>> BeginImport() override;

 private:
  InMemoryMotionStore& store_;
};

class InMemoryMotionStore final : public storage::MotionStore, public storage::AnnotationStore {
 public:
  // `lease_time_us`: clock of the leases.
  explicit InMemoryMotionStore(std::int64_t put_time_us,
                               std::function<std::int64_t()> lease_time_us = {})
      : put_time_us_(put_time_us), lease_time_us_(std::move(lease_time_us)) {}

  absl::Status CreateDatabase(const storage::DatabaseRecord& record,
                              const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<storage::DatabaseRecord> GetDatabase(const std::string& database) override;
  absl::StatusOr<std::vector<storage::DatabaseRecord>> ListDatabases(
      const storage::Page& page) override;
  absl::Status ReplaceMarkerSet(const std::string& database, const std::string& before,
                                const std::string& text,
                                const storage::WriteOptions& terms = {}) override;
  absl::Status DeleteDatabase(const std::string& database,
                              const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<std::vector<storage::DatabaseState>> ListDatabaseStates() override;
  absl::Status PurgeDeletedDatabases(const core::Cancelled&) override { return absl::OkStatus(); }
  absl::Status CheckWrites() override { return absl::OkStatus(); }
  storage::WriteFailures write_failures() const override { return {}; }

  absl::StatusOr<storage::ClipRecord> AddClip(const storage::NewClip& clip) override;
  absl::StatusOr<storage::ClipRecord> FindSameClip(const storage::NewClip& clip) override;
  absl::StatusOr<storage::ClipRecord> ReplaceClip(const storage::ClipRecord& before,
                                                  const storage::NewClip& clip) override;
  absl::StatusOr<storage::ClipRecord> GetClip(const std::string& database,
                                              const std::string& clip) override;
  absl::StatusOr<std::vector<storage::ClipRecord>> ListClips(const std::string& database,
                                                             const storage::Page& page) override;
  absl::StatusOr<storage::ClipRecord> DeleteClip(const std::string& database,
                                                 const std::string& clip,
                                                 const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<storage::ClipSource> ReadClipSource(const std::string& database,
                                                     const std::string& clip) override;
  absl::StatusOr<core::StateSequence> ReadClipStates(const std::string& database,
                                                     const std::string& clip) override;

  absl::StatusOr<std::vector<storage::ClipRecord>> PutDerived(
      const std::string& database, std::span<const storage::DerivedClip> clips,
      std::int64_t fence = 0) override;

  absl::StatusOr<core::Skeleton> GetSkeleton(const std::string& database,
                                             const std::string& skeleton) override;
  absl::StatusOr<std::vector<storage::SkeletonRecord>> ListSkeletons(
      const std::string& database, const storage::Page& page) override;

  absl::StatusOr<storage::ModelRecord> PutModel(const std::string& database,
                                                const core::Model& model,
                                                const storage::ModelTerms& terms = {}) override;
  absl::StatusOr<storage::ModelRecord> PutExtension(const std::string& database,
                                                    const core::Model& model, double drift_fraction,
                                                    const storage::ModelTerms& terms = {}) override;
  absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                        const core::ParallelFor& parallel) override;
  absl::StatusOr<core::Model> ReadExtension(const std::string& database, std::int32_t base_version,
                                            const core::Model& base,
                                            const core::ParallelFor& parallel) override;
  absl::StatusOr<storage::ModelStaleness> FindModelStaleness(const std::string& database) override;
  absl::StatusOr<storage::ModelRecord> GetModel(const std::string& database, int version) override;
  absl::StatusOr<std::vector<storage::ModelRecord>> ListModels(const std::string& database,
                                                               int before, int limit) override;
  absl::Status DropModel(const std::string& database,
                         const storage::ModelTerms& terms = {}) override;
  absl::Status PurgeDeletedClips(const std::string& database,
                                 const core::Cancelled& cancelled = {}) override;

  absl::StatusOr<std::int64_t> AcquireBuildLease(const std::string& database,
                                                 const std::string& holder,
                                                 std::chrono::milliseconds duration) override;
  absl::Status RenewBuildLease(const std::string& database, std::int64_t fence,
                               std::chrono::milliseconds duration) override;
  absl::Status ReleaseBuildLease(const std::string& database, std::int64_t fence) override;

  absl::Status PutOperation(const storage::OperationRecord& record,
                            const core::Cancelled& cancelled = {}) override;
  absl::StatusOr<storage::OperationRecord> GetOperation(const std::string& operation) override;
  absl::StatusOr<std::vector<storage::OperationRecord>> ListOperations(const std::string& database,
                                                                       const std::string& before,
                                                                       int limit) override;
  absl::StatusOr<std::vector<storage::OperationRecord>> ListUnfinishedOperations() override;
  storage::AnnotationStore& annotations() override { return *this; }
  absl::StatusOr<storage::EditRecord> Edit(const std::string& database,
                                           std::span<const storage::Change> changes,
                                           const std::string& author,
                                           const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<storage::EditRecord> UndoEdit(const std::string& database, std::int64_t edit,
                                               const std::string& author,
                                               const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<std::vector<storage::EditRecord>> ListEdits(const std::string& database,
                                                             const std::string& clip,
                                                             std::int64_t before,
                                                             int limit) override;
  absl::StatusOr<storage::SegmentRecord> GetSegment(const std::string& database,
                                                    const std::string& clip,
                                                    const std::string& segment) override;
  absl::StatusOr<std::vector<storage::SegmentRecord>> ListSegments(
      const std::string& database, const std::string& clip) override;
  absl::StatusOr<std::int64_t> Revision(const std::string& database) override;
  absl::StatusOr<std::vector<storage::ChangeRecord>> Changes(const std::string& database,
                                                             std::int64_t after, int limit,
                                                             std::int64_t begun = 0) override;
  absl::StatusOr<std::vector<storage::TextMatch>> SearchClips(const std::string& database,
                                                              const std::string& query) override;

  storage::AccessStore& access() override { return access_; }
  storage::StoreMaintenance& maintenance() override { return maintenance_; }

 private:
  friend class InMemoryMaintenance;
  friend class InMemoryImport;
  friend struct InMemoryExport;
  using Segments = std::vector<storage::SegmentRecord>;
  struct Tombstone {
    std::int64_t revision = 0;
    storage::Deleted deleted;
  };
  struct Database {
    storage::DatabaseRecord record;
    std::map<std::string, storage::NewClip> clips;
    std::vector<storage::NewClip> deleted;  // deleted clips that a model may still use
    std::set<std::string> replaced;         // clips whose states were replaced since the last build
    std::map<std::string, core::Skeleton> skeletons;
    std::vector<storage::ModelRecord> models;  // version 1 first
    std::optional<core::Model> model;
    std::map<std::string, Segments> segments;  // by clip, in order of track and start
    std::int64_t revision = 0;
    std::int64_t model_revision = 0;
    std::vector<storage::EditRecord> edits;  // oldest first
    std::vector<Tombstone> tombstones;       // oldest first
    std::int64_t removed_revision = 0;
    std::int64_t id = 0;
    std::string lease_holder;     // empty: released
    std::int64_t last_fence = 0;  // 0: there was no lease
    std::int64_t lease_expire_us = 0;
    int built_version = 0;  // the build that the current model is or extends
  };

  // Returns whether the clip of the model was built from `stored`.
  static bool IsOf(const storage::NewClip& stored, const core::Model& model,
                   const core::ModelClip& clip);
  // Returns whether the clip of the model is the stored clip of that id.
  static bool Holds(const Database& in, const core::Model& model, const core::ModelClip& clip);
  // Makes `model` the current model. NOT_FOUND if one of its clips from index `first` on is not
  // stored; if `first` is 0, deleted clips are accepted too.
  absl::StatusOr<storage::ModelRecord> Put(Database& in, const core::Model& model, int first);
  // AddClip and DeleteClip, with mutex_ locked. `former`: segments of the clip that is replaced.
  absl::StatusOr<storage::ClipRecord> Add(Database& in, const storage::NewClip& clip,
                                          const Segments& former);
  static void Remove(Database& in, const std::string& clip);
  // Sets the segments of a clip after a change of one of them.
  static void SetSegments(Database& in, const std::string& clip, Segments segments);
  static void Bury(Database& in, const storage::Deleted& deleted, std::int64_t revision);
  static void Unbury(Database& in, const storage::Deleted& deleted);
  using Plan = std::function<absl::StatusOr<std::vector<storage::EditedObject>>(
      const storage::LoadClip& load, const storage::ChangeStamp& stamp)>;
  absl::StatusOr<storage::EditRecord> Make(Database& in, const Plan& plan,
                                           const std::string& author,
                                           const storage::WriteOptions& terms);
  // Adds a copy of a database under another name.
  absl::Status AddCopy(Database copy, const std::string& name, const storage::WriteOptions& terms);
  std::int64_t LeaseTimeUs() const { return lease_time_us_ ? lease_time_us_() : put_time_us_; }
  // See ModelTerms.
  static absl::Status CheckTerms(const Database& in, const storage::ModelTerms& terms);
  absl::Status Note(const storage::WriteOptions& terms);
  // `id` 0: any.
  absl::StatusOr<Database*> Find(const std::string& database, std::int64_t id = 0);
  absl::StatusOr<storage::NewClip*> FindClip(const std::string& database, const std::string& clip);

  const std::int64_t put_time_us_;
  const std::function<std::int64_t()> lease_time_us_;
  std::int64_t last_id_ = 0;  // of a database
  std::int64_t last_fence_ = 0;
  std::mutex mutex_;
  std::map<std::string, Database> databases_;
  std::vector<storage::OperationRecord> operations_;  // oldest first
  InMemoryAccessStore access_;
  InMemoryMaintenance maintenance_{*this};
};

}  // namespace motiondb::tests
