// Decides when a database's model is rebuilt, and runs the builds. Thread-safe.
//
// A rebuild is an operation. It is asked for with each change of the clips and stays PENDING until
// no ingest of its database is in flight and none has come for a while; whoever asks meanwhile is
// given the same operation, so a burst of ingests costs one build. Whoever asks while a build runs
// gets the operation that follows it. A database has one build at a time, the server as many as it
// has build threads. One that failed for want of room is asked for again after a while.
#pragma once

#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/engine/live_database.h"
#include "server/engine/operation_book.h"
#include "server/engine/rebuild.h"
#include "server/engine/workers.h"

namespace motiondb::server {

class Rebuilder {
 public:
  // All must outlive the rebuilder.
  Rebuilder(storage::MotionStore& store, OperationBook& book, Workers& workers,
            const EngineOptions& options)
      : store_(store), book_(book), workers_(workers), options_(options) {}
  ~Rebuilder() { Stop(); }

  // The operation that will rebuild the model from the clips there are by now, at least. CANCELLED
  // where it was cancelled before that could be stored: it is then asked for again, by nobody.
  // REQUIRES here, where an Ingest begins, and of Cancel: within LiveDatabase::WhileAlive.
  absl::StatusOr<storage::OperationRecord> Request(const std::shared_ptr<LiveDatabase>& database,
                                                   const core::Cancelled& cancelled = {});
  // Takes up an operation of a former server, which OperationBook::Adopt made PENDING.
  void Resume(const std::shared_ptr<LiveDatabase>& database, const std::string& operation);

  // Counts an ingest as in flight for as long as it lives.
  class Ingest {
   public:
    Ingest(Rebuilder& rebuilder, std::shared_ptr<LiveDatabase> database);
    ~Ingest();
    Ingest(const Ingest&) = delete;
    Ingest& operator=(const Ingest&) = delete;

   private:
    Rebuilder& rebuilder_;
    const std::shared_ptr<LiveDatabase> database_;
  };

  // Asks an operation to stop: a waiting one is CANCELLED at once, one at work soon. The clips
  // stay; the next change, or the next start of the server, rebuilds. False where that changes
  // nothing: it is over, or is to stop already. CANCELLED, with nothing changed, where this was
  // itself cancelled before that could be stored.
  absl::StatusOr<bool> Cancel(const LiveDatabase& database, const std::string& operation,
                              const core::Cancelled& cancelled = {});
  // The database was deleted: its operations end, and its build stops without storing anything.
  // REQUIRES: within LiveDatabase::Retire.
  void Forget(const LiveDatabase& database);
  // Starts nothing more and stops what runs, whose operations are PENDING again; returns when
  // nothing runs.
  void Stop();

 private:
  using Clock = std::chrono::steady_clock;
  enum class StopReason { kNone, kCancelled, kForgotten, kShutdown };

  struct Build {
    std::string operation;
    std::shared_ptr<LiveDatabase> database;
    std::atomic<StopReason> stop{StopReason::kNone};
    bool wants_retry = false;
  };

  // What one database waits for.
  struct Queue {
    Queue(std::shared_ptr<LiveDatabase> for_database, const Workers::Executor& executor)
        : database(std::move(for_database)), timer(executor), retry(executor) {}
    std::shared_ptr<LiveDatabase> database;
    std::deque<std::string> waiting;  // more than one only after a restart
    std::string held_back;  // of those, while its cancellation is stored: not begun, not joined
    Clock::time_point first_asked;
    Clock::time_point last_asked;
    int ingests = 0;
    std::shared_ptr<Build> running;
    boost::asio::steady_timer timer;
    boost::asio::steady_timer retry;  // of a build that failed, unless another is asked for
  };

  // The operation that waits already, which serves who asks now too; nothing where none does.
  std::optional<storage::OperationRecord> Join(const std::shared_ptr<LiveDatabase>& database);
  absl::StatusOr<storage::OperationRecord> RequestInTurn(
      const std::shared_ptr<LiveDatabase>& database, const core::Cancelled& cancelled);
  // A request that nobody waits for, on this thread.
  void RequestForNobody(const std::shared_ptr<LiveDatabase>& database);
  // False where the operation does not wait.
  bool HoldBack(const LiveDatabase& database, const std::string& operation);
  // Whether that stops an operation at work.
  bool StopRunning(const LiveDatabase& database, const std::string& operation);

  // All with mutex_ held.
  Queue& QueueOf(const std::shared_ptr<LiveDatabase>& database);
  Queue* FindQueue(const LiveDatabase& database);
  Clock::time_point DueTime(const Queue& queue) const;
  // After each change of the queue: sets its timer, and tells the database its operation.
  void Arm(Queue& queue);
  void RetryLater(Queue& queue);
  std::shared_ptr<Build> TakeDue(const std::string& database);

  void OnTimer(const std::string& database);
  void Run(Build& build);
  void Finish(const std::shared_ptr<Build>& build);
  void StoreEnd(const Build& build, const absl::StatusOr<Rebuilt>& rebuilt);

  storage::MotionStore& store_;
  OperationBook& book_;
  Workers& workers_;
  const EngineOptions options_;

  // Held by who makes an operation wait, or no longer wait, while that is stored. Before mutex_.
  std::timed_mutex waiting_mutex_;
  std::mutex mutex_;  // not held while anything is stored: each ingest takes it
  std::condition_variable none_runs_;
  std::map<std::string, Queue> queues_;
  int running_ = 0;
  bool stopped_ = false;
};

}  // namespace motiondb::server
