// The life of one database's model: when it is built and extended, and the only place that changes
// which model answers queries.
//
// A build is an operation. Each change of the clips asks for one; whoever asks while an operation
// waits gets the same one, so a burst of ingests costs one build, and whoever asks while one is at
// work gets the one that follows it.
//
//   state     | event                                      | next state
//   ----------|--------------------------------------------|-------------------------------------
//   kIdle     | Request: an operation is stored, PENDING   | kWaiting
//   kWaiting  | no ingest is in flight, and none came for  | kBuilding: RUNNING
//             | rebuild_delay; or rebuild_delay_limit      |
//             | Cancel: CANCELLED                          | kIdle, or kWaiting for the next
//   kBuilding | the model answers: SUCCEEDED               | kIdle, or kWaiting for the next
//             | Cancel: CANCELLED                          | the same
//             | error: FAILED                              | the same; where room was lacking,
//             |                                            | Request after rebuild_retry_delay
//   any       | Stop: what is at work is PENDING again     | kClosed, once nothing is at work
//             | Forget (deleted): all are CANCELLED        | kClosed
//
// Beside that, extensions let the model that answers know new clips within a second: each stored
// clip asks for one, and one takes in all that have come. A build and an extension exclude each
// other only while one of them puts its model (LiveDatabase::model_mutex).
//
// Thread-safe. Builds run on Pool::kBuilds, extensions on Pool::kExtensions. They and the timers
// keep the database alive while they work, not while they wait.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "core/motion/cancellation.h"
#include "server/engine/executor.h"
#include "server/engine/live_database.h"
#include "server/engine/operation_book.h"
#include "server/engine/rebuild.h"
#include "storage/mutex.h"

namespace motiondb::server {

// What the engine lends to each lifecycle; all outlive it.
struct LifecycleServices {
  storage::MotionStore& store;
  OperationBook& operations;
  Executor& executor;
  const EngineOptions& options;
};

class ModelLifecycle {
 public:
  // `database` owns it.
  ModelLifecycle(LiveDatabase& database, const LifecycleServices& services);

  // The operation that will rebuild the model from the clips there are by now, at least. CANCELLED
  // if the caller gave up before the operation was persisted; it is then re-queued in the
  // background. REQUIRES here, where an Ingest begins, of RequestExtension and of Cancel: within
  // LiveDatabase::WhileAlive.
  absl::StatusOr<storage::OperationRecord> Request(const core::Cancelled& cancelled = {});
  // Takes up an operation of a former server, which OperationBook::Adopt made PENDING.
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
  // clips stay; the next change, or the next start of the server, rebuilds. False where that
  // changes nothing: it is over, or is to stop already. CANCELLED, with nothing changed, if the
  // caller gave up before that was persisted.
  absl::StatusOr<bool> Cancel(const std::string& operation, const core::Cancelled& cancelled = {});

  // Removes what deleted clips leave, unless a build is at work, which may have read them and
  // removes them when it ends. REQUIRES: within LiveDatabase::WhileAlive.
  void PurgeUnlessBuilding(const core::Cancelled& cancelled);

  // The database was deleted: its operations end, and its build stops without storing anything.
  // REQUIRES: within LiveDatabase::Retire.
  void Forget();
  // Starts nothing more, and asks what is at work to stop. Its operation is PENDING again.
  void BeginStop();
  // REQUIRES: BeginStop or Forget came before. Returns when nothing is at work.
  void AwaitStop();

 private:
  enum class StopReason { kNone, kCancelled, kForgotten, kShutdown };
  struct Build {
    std::string operation;
    std::atomic<StopReason> stop{StopReason::kNone};
  };
  enum class State { kIdle, kWaiting, kBuilding, kClosed };

  State state() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Executor::Clock::time_point DueTime() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The operation that waits already, which serves who asks now too.
  std::optional<storage::OperationRecord> Join() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Enqueue(const std::string& operation) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // After each transition: sets the timer, and shows the database's operation.
  void Arm() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Close() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  absl::StatusOr<storage::OperationRecord> RequestStored(const core::Cancelled& cancelled);
  // A request that nobody waits for.
  void RequestInBackground();

  // Transitions of builds, on a build thread: waiting -> at work -> over.
  void BeginIfDue();
  absl::StatusOr<Rebuilt> Run(Build& build);
  void StoreEnd(const Build& build, const absl::StatusOr<Rebuilt>& rebuilt);
  void End(const absl::StatusOr<Rebuilt>& rebuilt);

  void ArmExtension(Executor::Clock::duration rest) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void RunExtension();

  // Work that keeps the database alive while it runs.
  Executor::Work Alive(void (ModelLifecycle::*work)());

  LiveDatabase& database_;
  const LifecycleServices services_;

  storage::Mutex mutex_;  // not held while anything is stored: each ingest takes it
  storage::ConditionVariable changed_;
  std::deque<std::string> waiting_ ABSL_GUARDED_BY(mutex_);  // more than one after a restart only
  std::shared_ptr<Build> running_ ABSL_GUARDED_BY(mutex_);
  bool is_storing_request_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_closed_ ABSL_GUARDED_BY(mutex_) = false;
  Executor::Clock::time_point first_asked_ ABSL_GUARDED_BY(mutex_);
  Executor::Clock::time_point last_asked_ ABSL_GUARDED_BY(mutex_);
  int ingests_ ABSL_GUARDED_BY(mutex_) = 0;               // in flight
  bool extension_waits_ ABSL_GUARDED_BY(mutex_) = false;  // for its time, or the end of another
  bool is_extending_ ABSL_GUARDED_BY(mutex_) = false;
  // Null once it is closed: the executor may go before the database.
  std::unique_ptr<Executor::Timer> due_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Executor::Timer> retry_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<Executor::Timer> extension_due_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
