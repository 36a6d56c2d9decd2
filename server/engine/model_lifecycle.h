// The model of one database, from the first clip to the deletion. Owns the model that answers
// queries and everything that replaces it. Nothing else builds, extends, stores or serves a model.
//
// A build is an operation. Each change of the clips requests one. Requests join an operation that
// is still waiting, so a burst of ingests costs one build. Requests during a build get the next
// operation.
//
//   state     | event                                      | next state
//   ----------|--------------------------------------------|-------------------------------------
//   kIdle     | Request: an operation is stored, PENDING   | kWaiting
//   kWaiting  | no purge is running, and no ingest is      | kBuilding: RUNNING
//             | running or came for rebuild_delay, or      |
//             | rebuild_delay_limit has passed             |
//             | Cancel: CANCELLED                          | kIdle, or kWaiting for the next
//   kBuilding | the model is built: it is served from      | kBuilding
//             | memory while it is calibrated              |
//             | the model is calibrated: it is stored and  | kIdle, or kWaiting for the next
//             | served, SUCCEEDED                          |
//             | Cancel: CANCELLED                          | kIdle, or kWaiting for the next
//             | error: FAILED                              | same; if out of memory or disk space,
//             |                                            | Request after rebuild_retry_delay
//   any       | Stop: a build ends, and is PENDING again   | kClosed; then AwaitStop returns
//             | Forget (deleted): all are CANCELLED        | kClosed
//
// The model is replaced in one place (Replace), one replacement at a time. (LoadStored serves the
// first one, before any caller, and Forget none, after the last.)
//
//   new model                 | when                                         | stored
//   --------------------------|----------------------------------------------|--------------------
//   the stored model          | the server starts; or, with a limit of       | yes
//                             | memory, it is first used (Use)               |
//   only its record           | it is evicted (Evict)                        | yes
//   an extension by clips     | soon after each clip, if builds take long    | if its base is
//   the model, relabelled     | soon after labels were edited                | no
//   the model, refitted       | then, by an operation                        | yes
//   a new model, borrowing    | it is built                                  | no
//   the new model, calibrated | it is calibrated                             | yes
//   none                      | a build finds no clip                        | yes
//
// A new model borrows the calibration of its predecessor until its own is computed
// (Snapshot::calibration). It is not stored meanwhile and has no version of its own, so a reported
// version always identifies the same model, also after a crash. After a crash the stored model
// answers, and the unfinished operation builds again. A new model continues to answer if the rest
// of its build fails or is cancelled: it has newer clips than the stored model. The next build
// replaces it.
//
// Several servers may share the store (MotionStore::is_shared), each with its own lifecycle:
// - A build, and an extension, needs the lease of the database (BuildLease). A build without it, or
//   without the store, waits for another second. One that cannot read what a newer server has
//   stored waits for the next change, or rebuild_retry_delay.
// - Unfinished operations of other servers wait here too (Follow), a little longer than there: if
//   their server has stopped, this one runs them.
// - A request joins a waiting operation only if it is PENDING in the store. Its server, whichever
//   it is, then reads the clips later.
// - The served model follows the stored one (Followed).
// - A build whose lease another server has taken over is dropped: the store has refused its model.
// - A build that a server did not request because it stopped is requested here (MissedBuild).
//
// Builds run on Pool::kBuilds, extensions on Pool::kExtensions. They and the timers keep the
// database alive while they run, not while they wait.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "server/engine/build_lease.h"
#include "server/engine/snapshot.h"
#include "server/engine/work/executor.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::storage {
class MotionStore;
}  // namespace motiondb::storage

namespace motiondb::server {

class Catalog;
class CorruptionLog;
class LiveDatabase;
class OperationRegistry;
struct EngineOptions;

// Services of the engine; all outlive the lifecycle.
struct LifecycleServices {
  storage::MotionStore& store;
  OperationRegistry& operations;
  CorruptionLog& corruptions;
  Executor& executor;
  const EngineOptions& options;
  std::string holder = {};  // name of this server in leases
  // Evicts models of other databases until a model of this size (bytes) fits; empty: no limit.
  std::function<void(std::int64_t)> make_room = {};
};

// Results and total duration of the builds since the start.
struct RebuildTally {
  std::int64_t succeeded = 0;
  std::int64_t failed = 0;
  std::int64_t cancelled = 0;  // by a caller or by the shutdown
  double seconds = 0;
};

// Returns the memory of a model (bytes), estimated from its size.
std::int64_t BytesOfModel(const storage::ModelRecord& record);
// Returns a stored model that is not in memory.
ServedModel Unloaded(storage::ModelRecord record);

// Build leases since the start.
struct LeaseTally {
  bool is_held = false;  // now
  std::int64_t acquired = 0;
  std::int64_t refused = 0;  // another server had it
  std::int64_t lost = 0;     // to another server during a build
};

class ModelLifecycle {
 public:
  // `database` owns it.
  ModelLifecycle(LiveDatabase& database, const LifecycleServices& services);

  // Serves the stored model, or with a limit of memory its record. If it cannot be read, logs the
  // corruption and serves none. Called once, before the database is visible to callers.
  void LoadStored();

  // The model that answers queries; null if there is none, or if it is not in memory.
  std::shared_ptr<const Snapshot> snapshot() const;
  // The same, with the revision that it contains.
  ServedModel served() const;
  // The same, for a query. If the model is not in memory, starts to read it and returns
  // AwaitsChange; LiveDatabase::signal then notifies the result. An error of reading is returned
  // for a second.
  absl::StatusOr<ServedModel> Use();
  // Memory of the model (bytes), as estimated from its size; 0 if it is not in memory.
  std::int64_t model_bytes() const;
  // Time of the last Use or replacement.
  Executor::Clock::time_point last_use() const;
  // Whether the model is being updated or will be soon; it makes room when that has ended.
  bool IsUpdating() const;
  // Drops the model from memory, unless it is not stored, is being replaced, or a stream uses it.
  // Returns whether it did.
  bool Evict();
  // Returns whether the snapshot is stored, has all readable clips and has not drifted too far.
  absl::StatusOr<bool> IsUpToDate();
  // Id of the running or else the next waiting build operation; empty: none.
  std::string operation() const;
  RebuildTally rebuilds() const;
  LeaseTally leases() const;

  // Returns the operation that will build the model from at least the clips stored by now.
  // CANCELLED if the caller gave up before the operation was persisted; it is then re-queued in the
  // background. REQUIRES, also for Ingest, RequestUpdate and Cancel: called within
  // LiveDatabase::WithSharedUse.
  absl::StatusOr<storage::OperationRecord> Request(const core::Cancelled& cancelled = {});
  // Returns the operation that will derive all clips stored by now again (Reprocess) and rebuild
  // the model. CANCELLED, with nothing changed. REQUIRES: as above.
  absl::StatusOr<storage::OperationRecord> RequestReprocess(const core::Cancelled& cancelled = {});
  // Resumes an operation of a previous server, which OperationRegistry::Adopt made PENDING.
  void Resume(const std::string& operation);
  // Schedules an update of the model by the clips and labels stored by now.
  void RequestUpdate();
  // Of a shared store: takes over what other servers have changed. `unfinished`: the ids of the
  // unfinished operations of the database. `is_changed`: the database has changed.
  void Follow(const std::vector<std::string>& unfinished, bool is_changed);

  // Counts an ingest as in flight for as long as it lives.
  class Ingest {
   public:
    explicit Ingest(std::shared_ptr<LiveDatabase> database);
    ~Ingest();
    Ingest(const Ingest&) = delete;
    Ingest& operator=(const Ingest&) = delete;

   private:
    const std::shared_ptr<LiveDatabase> database_;
  };

  // Cancels an operation: a waiting one immediately, a running one soon. The clips stay; the next
  // change or server start builds them. Returns false if the operation is already done or stopping.
  // CANCELLED, with nothing changed, if the caller gave up before the cancellation was persisted.
  absl::StatusOr<bool> Cancel(const std::string& operation, const core::Cancelled& cancelled = {});

  // Purges the remains of deleted clips, unless a build is running: it may have read them, and
  // purges when it ends. Logs failures; the next purge retries. REQUIRES: within
  // LiveDatabase::WithSharedUse, or before the database is visible to callers.
  void PurgeUnlessBuilding(const core::Cancelled& cancelled = {});

  // The database was deleted: ends its operations, stops its build without storing anything, and
  // drops the model. REQUIRES: within LiveDatabase::Retire.
  void Forget();
  // Starts nothing more and stops the running build, whose operation becomes PENDING.
  void BeginStop();
  // Returns when no build or extension is running. REQUIRES: BeginStop or Forget was called.
  void AwaitStop();

 private:
  enum class State { kIdle, kWaiting, kBuilding, kClosed };
  enum class StopReason { kNone, kCancelled, kForgotten, kShutdown };
  using Lease = std::shared_ptr<BuildLease>;  // null: the store is not shared, or there is none
  struct Waiting {
    std::string operation;
    bool is_foreign = false;  // another server runs it, unless that has stopped
  };
  struct Build {
    std::string operation;
    Lease lease;
    bool is_deferred = false;  // the operation waits again
    bool is_newer = false;     // until this server can read what a newer one has stored
    std::atomic<StopReason> stop{StopReason::kNone};
    bool is_fenced() const { return lease != nullptr && lease->is_lost(); }
    bool stopped() const { return stop != StopReason::kNone || is_fenced(); }
    double derived = 0;  // share of the progress used for deriving clips again
  };
  struct Built {
    int version = 0;  // of the resulting model; 0: no clip is left
    // For the operator: result of deriving clips again, and DifferenceText.
    std::string difference;
  };
  // Computes the next model from the current one; null: no model.
  using Replacement = std::function<absl::StatusOr<ServedModel>(ServedModel)>;

  // Scheduling: the state machine (model_lifecycle.cc).
  State state() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Executor::Clock::time_point DueTime() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns the last waiting operation if it covers this request too. `last`: its id, in any case.
  std::optional<storage::OperationRecord> Join(storage::OperationKind kind, std::string& last);
  void Enqueue(Waiting waiting) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Removes an operation from the queue. Returns whether it was there.
  bool Remove(const std::string& operation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Close() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Called after each transition: sets the timer of the waiting operation.
  void ArmBuild() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ScheduleUpdate() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ArmUpdate(Executor::Clock::duration rest) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<storage::OperationRecord> RequestStored(storage::OperationKind kind,
                                                         const core::Cancelled& cancelled);
  // Request without a caller.
  void RequestInBackground();
  // Run by timers. kWaiting -> kBuilding -> the next state.
  void BuildIfDue();
  void UpdateIfOpen();
  // Wraps `work` so that it keeps the database alive while it runs.
  Executor::Work KeepAlive(void (ModelLifecycle::*work)());

  // The part for a shared store (model_lifecycle_shared.cc).
  bool is_shared() const { return services_.store.is_shared(); }
  // Returns the lease of the database, which users share; null if the store is not shared. ABORTED
  // if another server has it. NOT_FOUND if the database was deleted.
  absl::StatusOr<Lease> AcquireLease();
  // Returns the lease if this server has it.
  Lease HeldLease();
  // Returns whether a model may be stored with this lease.
  bool MayStore(const Lease& lease) const { return !is_shared() || lease != nullptr; }
  storage::ModelTerms TermsOf(const Lease& lease) const;
  // Returns the stored model if it is newer. Reads a model that is not in memory only if
  // `is_needed`. REQUIRES: within Replace.
  absl::StatusOr<ServedModel> Followed(ServedModel served, bool is_needed);
  absl::StatusOr<ServedModel> ReadNewer(const ServedModel& served, storage::ModelRecord newest);
  // Returns whether a stored snapshot is still the stored model. Then the staleness that was read
  // before is that of the snapshot.
  absl::StatusOr<bool> IsCurrent(const Snapshot& snapshot);

  // Requests a build that a server has not requested because it stopped (MissedBuild).
  void RequestMissedBuild();
  // Ends a build that needs to run again or that another server has taken over. Returns whether it
  // was one.
  bool EndUnfinished(Build& build, const absl::Status& built);

  // Memory (model_lifecycle_memory.cc).
  bool loads_on_demand() const;
  // Returns the stored model, read if it was not in memory; none if it is corrupt. REQUIRES: within
  // Replace.
  absl::StatusOr<ServedModel> Loaded(ServedModel served);
  void ReportUnreadable(const absl::Status& status);
  // Evicts models if a further one of this size would exceed the limit.
  void MakeRoom(std::int64_t bytes) {
    if (services_.make_room) services_.make_room(bytes);
  }
  // Returns the error to queries that wait for the model.
  void SetLoadError(const absl::Status& error);
  // Requests a build if the model is not up to date. Returns whether it did.
  absl::StatusOr<bool> RebuildIfOutdated();

  // Replacements of the model (model_lifecycle_work.cc).
  //
  // Returns whether a model whose build took so long is extended by clips.
  bool TakesClips(double build_seconds) const;
  absl::Status Replace(const Replacement& next);
  void Serve(ServedModel next);
  // Returns OK or the error of the build. The operation has ended when it returns.
  absl::Status RunBuild(Build& build);
  // Errors of OperationRegistry::Succeed.
  absl::Status EndOperation(const Build& build, const absl::StatusOr<Built>& built);
  // Derives outdated clips again (Reprocess), then builds a model of all clips.
  absl::StatusOr<Built> DeriveAndBuild(Build& build);
  // Returns the result as text for the operator; empty if there was nothing to derive.
  absl::StatusOr<std::string> DeriveOutdated(Build& build);
  // Uses the clips whose states are of the current representation version.
  absl::StatusOr<Built> BuildUntilStored(Build& build);
  // ABORTED if a clip of the model was deleted meanwhile.
  // `revision`: that the clips have at least.
  absl::StatusOr<Built> BuildAndStore(const Build& build,
                                      const std::vector<storage::ClipRecord>& clips,
                                      std::int64_t revision);
  // Fits the metric and the calibration of the current model to its labels.
  absl::StatusOr<Built> RefitAndStore(const Build& build);
  // Serves the model with the calibration of its predecessor.
  absl::Status ServeBorrowing(core::Model model, std::int64_t revision, const Lease& lease);
  // Returns the version.
  absl::StatusOr<int> StoreAndServe(core::Model model, std::int64_t revision, const Lease& lease);
  // Leaves the store without a current model.
  absl::Status DropStored(const Lease& lease);
  void PurgeDeletedClips(const core::Cancelled& cancelled);

  // Updates of the model (model_lifecycle_update.cc).
  // `may_extend`: acquires the lease to extend the model, if there is need. `is_used`: the model is
  // needed in memory.
  absl::Status UpdateCurrent(bool may_extend, bool is_used);
  // Returns the model with the clips and labels that are stored now. REQUIRES: within Replace.
  // Extends it only if MayStore(lease).
  absl::StatusOr<ServedModel> Updated(ServedModel served, const Lease& lease,
                                      const core::ParallelFor& parallel);
  // Returns the model, which is not null, with the stored labels of its clips.
  absl::StatusOr<ServedModel> Relabelled(ServedModel served);
  // The same with the labels of a catalog. `staleness`: of the model, found after the catalog was
  // read.
  absl::StatusOr<ServedModel> WithLabelsOf(const Catalog& catalog,
                                           const storage::ModelStaleness& staleness,
                                           ServedModel served);
  // Returns whether the model has the clips of the catalog. `staleness`: as above.
  bool HasChangesOf(const Snapshot& snapshot, const Catalog& catalog,
                    const storage::ModelStaleness& staleness) const;
  // Returns `snapshot` extended by its missing clips, which are then no longer in `staleness`.
  // Returns it unchanged if none are missing, or if a clip was deleted meanwhile. Stores the result
  // if `snapshot` is stored. REQUIRES: within Replace; it is extensible.
  absl::StatusOr<std::shared_ptr<const Snapshot>> Extended(std::shared_ptr<const Snapshot> snapshot,
                                                           storage::ModelStaleness& staleness,
                                                           const Lease& lease,
                                                           const core::ParallelFor& parallel);
  // `record`: of a stored model.
  absl::StatusOr<bool> HasAllClips(const storage::ModelRecord& record);
  absl::StatusOr<bool> HasAllClips(const Snapshot& snapshot);

  LiveDatabase& database_;
  const LifecycleServices services_;

  // Version of the current model in the store, as this server knows it; 0: none; -1: unknown.
  // Changes only within Replace.
  std::atomic<std::int32_t> stored_version_{-1};
  std::atomic<bool> newer_logged_{false};  // NewerFormat of the store

  mutable storage::Mutex lease_mutex_;  // held while the lease is acquired
  std::weak_ptr<BuildLease> lease_ ABSL_GUARDED_BY(lease_mutex_);
  std::atomic<std::int64_t> acquired_leases_{0};
  std::atomic<std::int64_t> refused_leases_{0};
  std::atomic<std::int64_t> lost_leases_{0};

  // Held from reading the current model to serving the next, so that no replacement is lost. Lock
  // order: before LiveDatabase::WithSharedUse and mutex_.
  storage::Mutex replace_mutex_;

  mutable storage::Mutex mutex_;  // not held during store access: each ingest locks it
  storage::ConditionVariable changed_;
  ServedModel served_ ABSL_GUARDED_BY(mutex_);
  Executor::Clock::time_point last_use_ ABSL_GUARDED_BY(mutex_);
  absl::Status load_error_ ABSL_GUARDED_BY(mutex_);  // of reading the model, at the time below
  Executor::Clock::time_point load_error_time_ ABSL_GUARDED_BY(mutex_);
  RebuildTally rebuilds_ ABSL_GUARDED_BY(mutex_);
  MissedBuild missed_build_ ABSL_GUARDED_BY(mutex_);
  std::deque<Waiting> waiting_ ABSL_GUARDED_BY(mutex_);  // several: restarted, or a shared store
  Executor::Clock::time_point not_before_ ABSL_GUARDED_BY(mutex_);  // of the next build
  bool awaits_change_ ABSL_GUARDED_BY(mutex_) = false;  // a change of the database ends not_before_
  std::shared_ptr<Build> running_ ABSL_GUARDED_BY(mutex_);
  bool is_storing_request_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
  Executor::Clock::time_point first_request_ ABSL_GUARDED_BY(mutex_);
  Executor::Clock::time_point last_request_ ABSL_GUARDED_BY(mutex_);
  int ingests_ ABSL_GUARDED_BY(mutex_) = 0;              // in flight
  int purges_ ABSL_GUARDED_BY(mutex_) = 0;               // running
  bool update_pending_ ABSL_GUARDED_BY(mutex_) = false;  // for its timer or the running one
  bool may_extend_ ABSL_GUARDED_BY(mutex_) = false;      // whether that acquires the lease
  bool is_used_ ABSL_GUARDED_BY(mutex_) = false;         // whether that needs the model in memory
  bool is_updating_ ABSL_GUARDED_BY(mutex_) = false;
  // Null once closed: the executor may be destroyed before the database.
  std::unique_ptr<Executor::Timer> due_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Executor::Timer> retry_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Executor::Timer> update_due_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
