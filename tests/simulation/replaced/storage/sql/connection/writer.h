// Takes the place of storage/sql/connection/writer.h in the simulation. All reads and writes of a
// simulated store pass it, each as one step. A session decides whether and when they reach the
// store.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "core/motion/execution.h"
#include "storage/sql/connection/connection.h"
#include "tests/simulation/world.h"

namespace motiondb::storage {

enum class Priority { kUrgent, kOrdinary, kBackground };

class Writer {
 public:
  class Session {
   public:
    virtual ~Session() = default;
    virtual Connection& connection() = 0;
    // Before a transaction. After an error it does not run.
    virtual absl::Status Begin(const core::Cancelled& cancelled) = 0;
    // Directly after it has been committed or rolled back.
    virtual void OnEnd() = 0;
    // On the way back. After an error, the caller does not learn the result.
    virtual absl::Status Answer() = 0;
  };

  explicit Writer(std::unique_ptr<Session> session) : session_(std::move(session)) {}

  template <typename Work>
  auto Run(Priority, const core::Cancelled& cancelled, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    using Result = std::invoke_result_t<Work, Connection&>;
    if (absl::Status begun = session_->Begin(cancelled); !begun.ok()) {
      return Result(std::move(begun));
    }
    std::optional<Result> result;
    {
      const simulation::World::Step step;
      result = work(session_->connection());
      session_->OnEnd();
    }
    if (absl::Status answered = session_->Answer(); !answered.ok()) {
      return Result(std::move(answered));
    }
    return *std::move(result);
  }

  using Body = std::function<absl::Status(Connection&)>;
  using Transact =
      std::function<absl::Status(Connection&, std::int64_t added_bytes, const Body& body)>;

  template <typename Work>
  auto RunShared(const Transact& transact, std::int64_t added_bytes,
                 const core::Cancelled& cancelled, const Work& work)
      -> std::invoke_result_t<Work, Connection&> {
    using Result = std::invoke_result_t<Work, Connection&>;
    return Run(Priority::kOrdinary, cancelled, [&](Connection& connection) {
      std::optional<Result> result;
      absl::Status done = transact(connection, added_bytes, [&](Connection& writer) {
        result = work(writer);
        return result->status();
      });
      return done.ok() ? *std::move(result) : Result(std::move(done));
    });
  }

 private:
  const std::unique_ptr<Session> session_;
};

}  // namespace motiondb::storage
