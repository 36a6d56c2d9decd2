// The model of one database, from the first clip to the deletion: owns the model that answers
// queries, and everything that replaces it. Nothing else builds, extends, stores or serves a model.
//
// A build is an operation. Each change of the clips requests one; whoever requests one while an
// operation waits gets the same one, so a burst of ingests costs one build, and whoever requests
// one during a build gets the one that follows it.
//
//   state     | event                                      | next state
//   ----------|--------------------------------------------|-------------------------------------
//   kIdle     | Request: an operation is stored, PENDING   | kWaiting
//   kWaiting  | no ingest and no purge is at work, and no  | kBuilding: RUNNING
//             | ingest came for rebuild_delay; or          |
//             | rebuild_delay_limit is over                |
//             | Cancel: CANCELLED                          | kIdle, or kWaiting for the next
//   kBuilding | the model is built: it is served from      | kBuilding
//             | memory, and calibrated meanwhile           |
//             | the model is calibrated: it is stored and  | kIdle, or kWaiting for the next
//             | served, SUCCEEDED                          |
//             | Cancel: CANCELLED                          | the same
//             | error: FAILED                              | the same; where room was lacking,
//             |                                            | Request after rebuild_retry_delay
//   any       | Stop: a build ends, and is PENDING again   | kClosed; AwaitStop returns then
//             | Forget (deleted): all are CANCELLED        | kClosed
//
// The model is replaced in one place (Replace), by one replacement at a time:
//
//   by                       | when                                          | stored
//   -------------------------|-----------------------------------------------|-------------------
//   the stored model         | the server starts                             | yes
//   an extension by clips    | soon after each clip, where builds take long  | as its base is
//   a new model, borrowing   | it is built                                   | no
//   the same, calibrated     | it is calibrated                              | yes
//   nothing                  | a build finds no clip                         | yes
//
// A new model borrows the calibration of its predecessor until its own is known
// (Snapshot::calibration). It is not stored meanwhile, so it has no version of its own: a version
// that was once reported is never that of another model, also after a crash. After a crash the
// stored model answers, and the operation, which is not done, builds again. A new model goes on
// answering if its build then fails or is cancelled: it knows more than the stored one, whose place
// it took. The next build replaces it.
//
// Thread-safe. Builds run on Pool::kBuilds, extensions on Pool::kExtensions. They and the timers
// keep the database alive while they work, not while they wait.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "server/engine/executor.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::core {
class Model;
}  // namespace motiondb::core

namespace motiondb::storage {
class MotionStore;
}  // namespace motiondb::storage

namespace motiondb::server {

class DamageBook;
class LiveDatabase;
class OperationRegistry;
struct EngineOptions;
struct Snapshot;

// What the engine lends to each lifecycle; all outlive it.
struct LifecycleServices {
  storage::MotionStore& store;
  OperationRegistry& operations;
  Executor& executor;
  const EngineOptions& options;
};

// How the builds since the start ended, and how long they took together.
struct RebuildTally {
  std::int64_t succeeded = 0;
  std::int64_t failed = 0;
  std::int64_t cancelled = 0;  // by a caller, or because the server stops
  double seconds = 0;
};

class ModelLifecycle {
 public:
  // `database` owns it.
  ModelLifecycle(LiveDatabase& database, const LifecycleServices& services);

  // Serves the stored model; none if it cannot be read, which is noted. Once, before others find
  // the database.
  void LoadStored(DamageBook& damages);

  // The model that answers queries; null while there is none.
  std::shared_ptr<const Snapshot> snapshot() const;
  // Whether that is stored, knows the clips that can be read, and may stay.
  absl::StatusOr<bool> IsUpToDate();
  // The operation of the build that waits or works; empty: none.
  std::string operation() const;
  RebuildTally rebuilds() const;

  // The operation that will build the model from the clips there are by now, at least. CANCELLED
  // if the caller gave up before the operation was persisted; it is then re-queued in the
  // background. REQUIRES here, where an Ingest begins, of RequestExtension and of Cancel: within
  // LiveDatabase::WithSharedUse.
  absl::StatusOr<storage::OperationRecord> Request(const core::Cancelled& cancelled = {});
  // The operation that will derive all clips again that are stored by now (Reprocess), and rebuild
  // the model. CANCELLED, with nothing changed. REQUIRES: as above.
  absl::StatusOr<storage::OperationRecord> RequestReprocess(const core::Cancelled& cancelled = {});
  // Takes up an operation of a former server, which OperationRegistry::Adopt made PENDING.
  void Resume(const std::string& operation);
  // Extends the model by the clips there are by now, soon.
  void RequestExtension();

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

  // Asks an operation to stop: a waiting one is CANCELLED immediately, a running one soon. The
  // clips stay; the next change, or the next start of the server, builds. False where that
  // changes nothing: it is over, or is to stop already. CANCELLED, with nothing changed, if the
  // caller gave up before that was persisted.
  absl::StatusOr<bool> Cancel(const std::string& operation, const core::Cancelled& cancelled = {});

  // Removes what deleted clips leave, unless a build is at work, which may have read them and
  // removes them when it ends. What cannot be removed is logged and stays until the next time.
  // REQUIRES: within LiveDatabase::WithSharedUse, or nobody knows the database yet.
  void PurgeUnlessBuilding(const core::Cancelled& cancelled = {});

  // The database was deleted: its operations end, its build stops without storing anything, and it
  // has no model. REQUIRES: within LiveDatabase::Retire.
  void Forget();
  // Starts nothing more, and asks what is at work to stop. Its operation is PENDING again.
  void BeginStop();
  // REQUIRES: BeginStop or Forget came before. Returns when nothing is at work.
  void AwaitStop();

 private:
  enum class State { kIdle, kWaiting, kBuilding, kClosed };
  enum class StopReason { kNone, kCancelled, kForgotten, kShutdown };
  struct Build {
    std::string operation;
    std::atomic<StopReason> stop{StopReason::kNone};
    bool stopped() const { return stop != StopReason::kNone; }
    double derived = 0;  // share of its progress that deriving clips again has taken
  };
  struct Built {
    int version = 0;  // of the model that then knows the clips; 0: no clip is left
    // For a person: what deriving clips again came to, and DifferenceText.
    std::string difference;
  };
  // The next model, made of the current one; both null where there is none.
  using Replacement = std::function<absl::StatusOr<std::shared_ptr<const Snapshot>>(
      std::shared_ptr<const Snapshot>)>;

  // Scheduling: the states (model_lifecycle.cc).
  State state() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Executor::Clock::time_point DueTime() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The operation that waits already, if it serves who asks now too.
  std::optional<storage::OperationRecord> Join(storage::OperationKind kind)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Enqueue(const std::string& operation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Close() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // After each transition: sets the timer of what waits.
  void ArmBuild() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ArmExtension(Executor::Clock::duration rest) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<storage::OperationRecord> RequestStored(storage::OperationKind kind,
                                                         const core::Cancelled& cancelled);
  // A request without a waiting caller.
  void RequestInBackground();
  // What the timers run. kWaiting -> kBuilding -> the next state.
  void BuildIfDue();
  void ExtendIfOpen();
  // Work that keeps the database alive while it runs.
  Executor::Work Alive(void (ModelLifecycle::*work)());

  // Work: what replaces the model (model_lifecycle_work.cc).
  absl::Status Replace(const Replacement& next);
  void Serve(std::shared_ptr<const Snapshot> snapshot);
  // OK, or why the build failed. The operation has ended when it returns.
  absl::Status RunBuild(Build& build);
  void EndOperation(const Build& build, const absl::StatusOr<Built>& built);
  // Derives the clips again that have to be (Reprocess), then makes the model know all clips.
  absl::StatusOr<Built> DeriveAndBuild(Build& build);
  // What deriving clips again came to, for a person; empty if there was nothing to derive.
  absl::StatusOr<std::string> DeriveWhereNeeded(Build& build);
  // Of clips whose states are of the present representation.
  absl::StatusOr<Built> BuildUntilStored(const Build& build);
  // ABORTED if a clip of the model was deleted meanwhile.
  absl::StatusOr<Built> BuildAndStore(const Build& build,
                                      const std::vector<storage::ClipRecord>& clips);
  // Serves it with the calibration of its predecessor.
  absl::Status ServeBorrowing(core::Model model);
  // Returns its version.
  absl::StatusOr<int> StoreAndServe(core::Model model);
  void ExtendCurrent();
  // The snapshot with the clips that it does not know; the same if it knows all, does not take
  // any, is null, or a clip was deleted meanwhile. Stored if `snapshot` is. REQUIRES: within
  // Replace.
  absl::StatusOr<std::shared_ptr<const Snapshot>> Extended(std::shared_ptr<const Snapshot> snapshot,
                                                           const core::ParallelFor& parallel);
  absl::StatusOr<bool> KnowsAllClips(const Snapshot& snapshot);
  // Leaves the store without a current model.
  absl::Status DropStored();
  void PurgeDeletedClips(const core::Cancelled& cancelled);

  LiveDatabase& database_;
  const LifecycleServices services_;

  // Held from reading the current model to serving the next, so that no replacement is lost. Taken
  // before LiveDatabase::WithSharedUse and mutex_.
  storage::Mutex replace_mutex_;

  mutable storage::Mutex mutex_;  // not held while anything is stored: each ingest takes it
  storage::ConditionVariable changed_;
  std::shared_ptr<const Snapshot> snapshot_ ABSL_GUARDED_BY(mutex_);
  RebuildTally rebuilds_ ABSL_GUARDED_BY(mutex_);
  std::deque<std::string> waiting_ ABSL_GUARDED_BY(mutex_);  // more than one after a restart only
  std::shared_ptr<Build> running_ ABSL_GUARDED_BY(mutex_);
  bool is_storing_request_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
  Executor::Clock::time_point first_asked_ ABSL_GUARDED_BY(mutex_);
  Executor::Clock::time_point last_asked_ ABSL_GUARDED_BY(mutex_);
  int ingests_ ABSL_GUARDED_BY(mutex_) = 0;               // in flight
  int purges_ ABSL_GUARDED_BY(mutex_) = 0;                // at work
  bool extension_waits_ ABSL_GUARDED_BY(mutex_) = false;  // for its time, or the end of another
  bool is_extending_ ABSL_GUARDED_BY(mutex_) = false;
  // Null once it is closed: the executor may go before the database.
  std::unique_ptr<Executor::Timer> due_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Executor::Timer> retry_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Executor::Timer> extension_due_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
