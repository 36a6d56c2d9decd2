// A store that forwards every call to another one. A test can block the begin or end of a build,
// block the begin of maintenance, or make reads of the model or writes fail.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "storage/motion_store.h"
#include "tests/support/full_disk.h"

namespace motiondb::tests {

// Blocks calls of a store. Must outlive it. Thread-safe.
class Gate {
 public:
  // Passing threads block until Open.
  void Close();
  void Open();
  // Waits until a thread is blocked.
  void AwaitArrival();

  // Called by the store.
  void Pass();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool closed_ = false;
  int waiting_ = 0;
};

// Verify, backup and restore pass `gate` first.
class GatedMaintenance final : public storage::StoreMaintenance {
 public:
  GatedMaintenance(storage::StoreMaintenance& maintenance, Gate& gate)
      : maintenance_(maintenance), gate_(gate) {}
  absl::Status CheckIsWritable() const override { return maintenance_.CheckIsWritable(); }
  std::vector<storage::Corruption> FoundAtOpening() const override {
    return maintenance_.FoundAtOpening();
  }
  absl::Status CheckFile() override { return maintenance_.CheckFile(); }
  absl::StatusOr<std::unique_ptr<storage::StoreVerifier>> BeginVerify(
      core::Cancelled cancelled) override {
    gate_.Pass();
    return maintenance_.BeginVerify(std::move(cancelled));
  }
  absl::StatusOr<std::unique_ptr<storage::StoreBackup>> BeginBackup(
      const core::Cancelled& cancelled) override {
    gate_.Pass();
    return maintenance_.BeginBackup(cancelled);
  }
  absl::StatusOr<std::unique_ptr<storage::StoreRestore>> BeginRestore() override {
    gate_.Pass();
    return maintenance_.BeginRestore();
  }
  absl::StatusOr<std::unique_ptr<storage::StoreBackup>> BeginExport(
      const std::string& database, const core::Cancelled& cancelled) override {
    gate_.Pass();
    return maintenance_.BeginExport(database, cancelled);
  }
  absl::StatusOr<std::unique_ptr<storage::DatabaseImport>> BeginImport() override {
    gate_.Pass();
    return maintenance_.BeginImport();
  }

 private:
  storage::StoreMaintenance& maintenance_;
  Gate& gate_;
};

// `disk` decides whether edits succeed.
class GatedAnnotations final : public storage::AnnotationStore {
 public:
  GatedAnnotations(storage::AnnotationStore& annotations, const SimulatedDisk& disk)
      : annotations_(annotations), disk_(disk) {}
  absl::StatusOr<storage::EditRecord> Edit(
      const std::string& database, std::span<const storage::Change> changes,
      const std::string& author, const storage::WriteOptions& work_options = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_.Write());
    return annotations_.Edit(database, changes, author, work_options);
  }
  absl::StatusOr<storage::EditRecord> UndoEdit(
      const std::string& database, std::int64_t edit, const std::string& author,
      const storage::WriteOptions& work_options = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_.Write());
    return annotations_.UndoEdit(database, edit, author, work_options);
  }
  absl::StatusOr<std::vector<storage::EditRecord>> ListEdits(const std::string& database,
                                                             const std::string& clip,
                                                             std::int64_t before,
                                                             int limit) override {
    return annotations_.ListEdits(database, clip, before, limit);
  }
  absl::StatusOr<storage::SegmentRecord> GetSegment(const std::string& database,
                                                    const std::string& clip,
                                                    const std::string& segment) override {
    return annotations_.GetSegment(database, clip, segment);
  }
  absl::StatusOr<std::vector<storage::SegmentRecord>> ListSegments(
      const std::string& database, const std::string& clip) override {
    return annotations_.ListSegments(database, clip);
  }
  absl::StatusOr<std::int64_t> Revision(const std::string& database) override {
    return annotations_.Revision(database);
  }
  absl::StatusOr<std::vector<storage::ChangeRecord>> Changes(const std::string& database,
                                                             std::int64_t after, int limit,
                                                             std::int64_t begun = 0) override {
    return annotations_.Changes(database, after, limit, begun);
  }
  absl::StatusOr<std::vector<storage::TextMatch>> SearchClips(const std::string& database,
                                                              const std::string& query) override {
    return annotations_.SearchClips(database, query);
  }

 private:
  storage::AnnotationStore& annotations_;
  const SimulatedDisk& disk_;
};

class GatedStore : public storage::MotionStore {
 public:
  // Each kind of call passes its gate first: `gate` reads of clip states and maintenance,
  // `model_gate` writes of a built model, `reading_gate` reads of a model, `derive_gate` writes of
  // derived clips. `disk` decides whether writes succeed.
  GatedStore(std::shared_ptr<storage::MotionStore> store, std::shared_ptr<Gate> gate,
             std::shared_ptr<Gate> model_gate = std::make_shared<Gate>(),
             std::shared_ptr<const SimulatedDisk> disk = std::make_shared<SimulatedDisk>(),
             std::shared_ptr<Gate> reading_gate = std::make_shared<Gate>(),
             std::shared_ptr<Gate> derive_gate = std::make_shared<Gate>())
      : store_(std::move(store)),
        gate_(std::move(gate)),
        model_gate_(std::move(model_gate)),
        disk_(std::move(disk)),
        reading_gate_(std::move(reading_gate)),
        derive_gate_(std::move(derive_gate)) {}

  // ReadModel returns `fault` from now on, unless it is OK.
  void set_model_fault(absl::Status fault) { model_fault_ = std::move(fault); }

  absl::Status CreateDatabase(const storage::DatabaseRecord& record,
                              const storage::WriteOptions& work_options = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->CreateDatabase(record, work_options);
  }
  absl::StatusOr<storage::DatabaseRecord> GetDatabase(const std::string& database) override {
    return store_->GetDatabase(database);
  }
  absl::StatusOr<std::vector<storage::DatabaseRecord>> ListDatabases(
      const storage::Page& page) override {
    return store_->ListDatabases(page);
  }
  absl::Status ReplaceMarkerSet(const std::string& database, const std::string& before,
                                const std::string& text,
                                const storage::WriteOptions& work_options = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->ReplaceMarkerSet(database, before, text, work_options);
  }
  absl::Status DeleteDatabase(const std::string& database,
                              const storage::WriteOptions& work_options = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->DeleteDatabase(database, work_options);
  }
  absl::StatusOr<std::vector<storage::DatabaseState>> ListDatabaseStates() override {
    return store_->ListDatabaseStates();
  }
  absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->PurgeDeletedDatabases(cancelled);
  }
  absl::StatusOr<storage::ClipRecord> AddClip(const storage::NewClip& clip) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->AddClip(clip);
  }
  absl::StatusOr<storage::ClipRecord> FindSameClip(const storage::NewClip& clip) override {
    return store_->FindSameClip(clip);
  }
  absl::StatusOr<storage::ClipRecord> ReplaceClip(const storage::ClipRecord& before,
                                                  const storage::NewClip& clip) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->ReplaceClip(before, clip);
  }
  absl::StatusOr<storage::ClipRecord> GetClip(const std::string& database,
                                              const std::string& clip) override {
    return store_->GetClip(database, clip);
  }
  absl::StatusOr<std::vector<storage::ClipRecord>> ListClips(const std::string& database,
                                                             const storage::Page& page) override {
    return store_->ListClips(database, page);
  }
  absl::StatusOr<storage::ClipRecord> DeleteClip(
      const std::string& database, const std::string& clip,
      const storage::WriteOptions& work_options = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->DeleteClip(database, clip, work_options);
  }
  absl::StatusOr<storage::ClipSource> ReadClipSource(const std::string& database,
                                                     const std::string& clip) override {
    return store_->ReadClipSource(database, clip);
  }
  absl::StatusOr<core::StateSequence> ReadClipStates(const std::string& database,
                                                     const std::string& clip) override {
    gate_->Pass();
    return store_->ReadClipStates(database, clip);
  }
  absl::StatusOr<std::vector<storage::ClipRecord>> PutDerived(
      const std::string& database, std::span<const storage::DerivedClip> clips,
      std::int64_t fence = 0) override {
    derive_gate_->Pass();
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->PutDerived(database, clips, fence);
  }
  absl::StatusOr<core::Skeleton> GetSkeleton(const std::string& database,
                                             const std::string& skeleton) override {
    return store_->GetSkeleton(database, skeleton);
  }
  absl::StatusOr<std::vector<storage::SkeletonRecord>> ListSkeletons(
      const std::string& database, const storage::Page& page) override {
    return store_->ListSkeletons(database, page);
  }
  absl::StatusOr<storage::ModelRecord> PutModel(const std::string& database,
                                                const core::Model& model,
                                                const storage::ModelTerms& terms = {}) override {
    model_gate_->Pass();
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->PutModel(database, model, terms);
  }
  absl::StatusOr<storage::ModelRecord> PutExtension(
      const std::string& database, const core::Model& model, double drift_fraction,
      const storage::ModelTerms& terms = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->PutExtension(database, model, drift_fraction, terms);
  }
  absl::StatusOr<core::Model> ReadExtension(const std::string& database, std::int32_t base_version,
                                            const core::Model& base,
                                            const core::ParallelFor& parallel) override {
    reading_gate_->Pass();
    return store_->ReadExtension(database, base_version, base, parallel);
  }
  absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                        const core::ParallelFor& parallel) override {
    reading_gate_->Pass();
    if (!model_fault_.ok()) return model_fault_;
    return store_->ReadModel(database, parallel);
  }
  absl::StatusOr<storage::ModelStaleness> FindModelStaleness(const std::string& database) override {
    return store_->FindModelStaleness(database);
  }
  absl::StatusOr<storage::ModelRecord> GetModel(const std::string& database, int version) override {
    return store_->GetModel(database, version);
  }
  absl::StatusOr<std::vector<storage::ModelRecord>> ListModels(const std::string& database,
                                                               int before, int limit) override {
    return store_->ListModels(database, before, limit);
  }
  absl::Status DropModel(const std::string& database,
                         const storage::ModelTerms& terms = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->DropModel(database, terms);
  }
  absl::StatusOr<std::int64_t> AcquireBuildLease(const std::string& database,
                                                 const std::string& holder,
                                                 std::chrono::milliseconds duration) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->AcquireBuildLease(database, holder, duration);
  }
  absl::Status RenewBuildLease(const std::string& database, std::int64_t fence,
                               std::chrono::milliseconds duration) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->RenewBuildLease(database, fence, duration);
  }
  absl::Status ReleaseBuildLease(const std::string& database, std::int64_t fence) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->ReleaseBuildLease(database, fence);
  }
  absl::Status PurgeDeletedClips(const std::string& database,
                                 const core::Cancelled& cancelled = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->PurgeDeletedClips(database, cancelled);
  }
  absl::Status PutOperation(const storage::OperationRecord& record,
                            const core::Cancelled& cancelled = {}) override {
    MOTIONDB_RETURN_IF_ERROR(disk_->WriteOperation());
    return store_->PutOperation(record, cancelled);
  }
  absl::StatusOr<storage::OperationRecord> GetOperation(const std::string& operation) override {
    return store_->GetOperation(operation);
  }
  absl::StatusOr<std::vector<storage::OperationRecord>> ListOperations(const std::string& database,
                                                                       const std::string& before,
                                                                       int limit) override {
    return store_->ListOperations(database, before, limit);
  }
  absl::StatusOr<std::vector<storage::OperationRecord>> ListUnfinishedOperations() override {
    return store_->ListUnfinishedOperations();
  }
  bool is_shared() const override { return store_->is_shared(); }
  absl::Status CheckWrites() override {
    MOTIONDB_RETURN_IF_ERROR(disk_->Write());
    return store_->CheckWrites();
  }
  storage::WriteFailures write_failures() const override { return store_->write_failures(); }
  storage::ConnectionStatistics connections() const override { return store_->connections(); }
  storage::AnnotationStore& annotations() override { return annotations_; }
  storage::AccessStore& access() override { return store_->access(); }
  storage::StoreMaintenance& maintenance() override { return maintenance_; }

 private:
  const std::shared_ptr<storage::MotionStore> store_;
  const std::shared_ptr<Gate> gate_;
  const std::shared_ptr<Gate> model_gate_;
  const std::shared_ptr<const SimulatedDisk> disk_;
  const std::shared_ptr<Gate> reading_gate_;
  const std::shared_ptr<Gate> derive_gate_;
  GatedMaintenance maintenance_{store_->maintenance(), *gate_};
  GatedAnnotations annotations_{store_->annotations(), *disk_};
  absl::Status model_fault_;
};

inline void Gate::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

inline void Gate::Open() {
  const std::lock_guard lock(mutex_);
  closed_ = false;
  changed_.notify_all();
}

inline void Gate::AwaitArrival() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_ > 0; });
}

inline void Gate::Pass() {
  std::unique_lock lock(mutex_);
  if (!closed_) return;
  ++waiting_;
  changed_.notify_all();
  changed_.wait(lock, [this] { return !closed_; });
  --waiting_;
}

// One server's access to a store that several servers share.
class SharedStore : public GatedStore {
 public:
  using GatedStore::GatedStore;
  bool is_shared() const override { return true; }
};

}  // namespace motiondb::tests
