// The one connection that writes and checkpoints, and the one thread that uses it. Work for it
// queues by priority; whoever submits it waits. Thread-safe.
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
#include "core/motion/cancellation.h"
#include "storage/mutex.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// Work that is queued begins in this order, and what has one priority in the order of submission. A
// transaction that has begun is never interrupted. So that constant changes do not keep background
// work waiting for ever, it has a turn after every four pieces of ordinary work.
enum class Priority {
  kUrgent,      // what ends a danger: a token is revoked, a build is cancelled; its audit entry
  kOrdinary,    // what a caller waits for
  kBackground,  // one of many pieces: of a model, of what is freed
};

class Writer {
 public:
  // `connection` may write. Throws std::system_error if the thread cannot be started.
  explicit Writer(std::unique_ptr<Connection> connection);
  // Runs what is queued, waits for its callers to leave, and closes the connection, which empties
  // the log. REQUIRES: nothing is submitted any more.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Runs work(Connection&), which returns a Status or StatusOr, on the thread and returns its
  // result. Throws what it throws. CANCELLED, without running it, if `cancelled`, which must not
  // throw, says so before it begins: asked on the calling thread. Not to be called from work.
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
  // Runs a body that adds so many bytes in a transaction: all of it happens, or after an error
  // none.
  using Transact =
      std::function<absl::Status(Connection&, std::int64_t added_bytes, const Body& body)>;

  // As Run, of ordinary work that returns a StatusOr and is to be done by `transact`. What is
  // queued side by side shares one transaction, and so one sync of the disk; where that fails, each
  // is done by itself. So work may be called twice.
  template <typename Work>
  auto RunInShared(const Transact& transact, std::int64_t added_bytes,
                   const core::Cancelled& cancelled, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    using Result = std::invoke_result_t<Work, Connection&>;
    std::optional<Result> result;
    const Share share{transact, added_bytes, [&](Connection& connection) {
                        result = work(connection);
                        return result->status();
                      }};
    const auto alone = [&](Connection& connection) {
      absl::Status done = transact(connection, added_bytes, share.body);
      if (!done.ok()) result = std::move(done);
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
  };

  // On the stack of its caller.
  struct Request {
    enum class State { kQueued, kRunning, kOver };
    const Piece* piece = nullptr;
    const Share* share = nullptr;  // in place of the piece, beside others; null: it shares nothing
    bool may_fail = false;         // AllocationsMayFail of the caller
    State state = State::kQueued;  // guarded by mutex_
    std::exception_ptr thrown;     // by the piece
    ConditionVariable is_over;
  };
  static constexpr std::size_t kPriorities = 3;
  using Queue = std::deque<Request*>;

  absl::Status Submit(Priority priority, const core::Cancelled& cancelled, const Piece& piece,
                      const Share* share = nullptr);
  void Serve();
  // Waits for the next requests, several only where they share a transaction. None: all have ended,
  // and none may come.
  const std::vector<Request*>& Next();
  void RunAlone(Request& request);
  // False, with nothing done, if one of them fails.
  bool RunTogether(const std::vector<Request*>& requests);
  // Where the next one is. Null if there is none.
  Queue* NextQueue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // For the thread alone.
  const std::unique_ptr<Connection> connection_;
  std::vector<Request*> taken_;
  Mutex mutex_;
  ConditionVariable changed_;
  std::array<Queue, kPriorities> queues_ ABSL_GUARDED_BY(mutex_);  // by Priority
  int passed_over_ ABSL_GUARDED_BY(mutex_) = 0;  // ordinary work, while background work waited
  int callers_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_closing_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace motiondb::storage
