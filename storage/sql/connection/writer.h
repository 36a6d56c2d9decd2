// The only connection that writes and checkpoints, and the only thread that uses it. Work is queued
// by priority; the caller waits for its work. Thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <type_traits>
#include <vector>

#include "absl/status/status.h"
#include "core/motion/execution.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Queued work begins in order of priority, and within a priority in order of submission. A running
// transaction is never interrupted. To prevent starvation, one piece of background work runs after
// every four pieces of ordinary work.
enum class Priority {
  kUrgent,      // work that prevents harm: revoke a token, cancel a build; audit entries
  kOrdinary,    // work that a caller waits for
  kBackground,  // one of many pieces: store a model, free disk space
};

class Writer {
 public:
  // `connection` may write. Throws std::system_error if the thread cannot be started.
  explicit Writer(std::unique_ptr<Connection> connection);
  // Runs the queued work, waits until its callers have returned, and closes the connection, which
  // empties the log. REQUIRES: no further work is submitted.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Runs work(Connection&), which returns a Status or StatusOr, on the writer thread. Returns its
  // result or rethrows its exception. CANCELLED if `cancelled` returns true before the work begins;
  // the work then does not run. `cancelled` is polled on the calling thread and must not throw. Do
  // not call Run from work.
  template <typename Work>
  auto Run(Priority priority, const core::Cancelled& cancelled, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    using Result = std::invoke_result_t<Work, Connection&>;
    std::optional<Result> result;
    absl::Status begun =
        Submit(priority, cancelled, [&](Connection& connection) { result = work(connection); });
    return begun.ok() ? *std::move(result) : Result(std::move(begun));
  }

  using Body = std::function<absl::Status(Connection&)>;
  // Runs a body that adds `added_bytes` in a transaction, which is rolled back on an error.
  using Transact =
      std::function<absl::Status(Connection&, std::int64_t added_bytes, const Body& body)>;

  // As Run with kOrdinary, for work that returns a StatusOr and that `transact` runs. Adjacent work
  // in the queue shares one transaction and so one sync of the disk. If that transaction fails,
  // each piece runs again in its own transaction: work may be called twice. After UNAVAILABLE none
  // does: the store is gone, and it may be unknown whether the changes were made.
  template <typename Work>
  auto RunShared(const Transact& transact, std::int64_t added_bytes,
                 const core::Cancelled& cancelled, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    using Result = std::invoke_result_t<Work, Connection&>;
    std::optional<Result> result;
    const Share share{transact, added_bytes,
                      [&](Connection& connection) {
                        result = work(connection);
                        return result->status();
                      },
                      [&](const absl::Status& failed) { result = failed; }};
    const auto alone = [&](Connection& connection) {
      absl::Status done = transact(connection, added_bytes, share.body);
      if (!done.ok()) share.fail(done);
    };
    absl::Status begun = Submit(Priority::kOrdinary, cancelled, alone, &share);
    return begun.ok() ? *std::move(result) : Result(std::move(begun));
  }

 private:
  using Piece = std::function<void(Connection&)>;
  struct Share {
    const Transact& transact;
    std::int64_t added_bytes = 0;
    Body body;
    std::function<void(const absl::Status&)> fail;  // sets the result
  };

  // Lives on the stack of its caller.
  struct Request {
    enum class State { kQueued, kRunning, kOver };
    const Piece* piece = nullptr;
    const Share* share = nullptr;  // used instead of `piece` in a shared transaction; may be null
    bool may_fail = false;         // AllocationsMayFail of the caller
    State state = State::kQueued;  // guarded by mutex_
    std::exception_ptr thrown;     // exception of the piece
    ConditionVariable is_over;
  };
  static constexpr std::size_t kPriorities = 3;
  using Queue = std::deque<Request*>;

  absl::Status Submit(Priority priority, const core::Cancelled& cancelled, const Piece& piece,
                      const Share* share = nullptr);
  void Serve();
  // Waits for the next request, or for several that share a transaction. Empty: the writer is
  // closing and all work is done.
  const std::vector<Request*>& Next();
  void RunAlone(Request& request);
  // Returns false, with nothing changed, if one of them fails. UNAVAILABLE is the result of all.
  bool RunTogether(const std::vector<Request*>& requests);
  // Returns the queue of the next request. Null if all are empty.
  Queue* NextQueue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // Used only by the writer thread.
  const std::unique_ptr<Connection> connection_;
  std::vector<Request*> taken_;
  Mutex mutex_;
  ConditionVariable changed_;
  std::array<Queue, kPriorities> queues_ ABSL_GUARDED_BY(mutex_);  // by Priority
  int passed_over_ ABSL_GUARDED_BY(mutex_) = 0;  // ordinary work begun while background work waited
  int callers_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_closing_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the other members
};

}  // namespace motiondb::storage
