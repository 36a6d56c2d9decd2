// Waits for an operation without blocking a thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "server/engine/work/executor.h"
#include "server/engine/work/operation_registry.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Keeps itself alive until it has ended; executor and registry must outlive it.
class OperationWait : public std::enable_shared_from_this<OperationWait> {
 public:
  using Done = std::function<void(absl::StatusOr<storage::OperationRecord>)>;

  // Calls `done` once, on a request thread, with the operation when it is done, the timeout has
  // passed or Stop was called. NOT_FOUND if the operation does not exist.
  static std::shared_ptr<OperationWait> Start(Executor& executor, OperationRegistry& registry,
                                              std::string id, Executor::Clock::duration timeout,
                                              Done done);
  // Ends the wait now.
  void Stop();

 private:
  OperationWait(Executor& executor, OperationRegistry& registry, std::string id, Done done);
  void Begin(Executor::Clock::duration timeout);
  void End(absl::StatusOr<storage::OperationRecord> record);

  Executor& executor_;
  OperationRegistry& registry_;
  const std::string id_;
  storage::Mutex mutex_;
  const std::unique_ptr<Executor::Timer> timer_ ABSL_PT_GUARDED_BY(mutex_);
  Done done_ ABSL_GUARDED_BY(mutex_);  // null: already called
  std::uint64_t watch_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace motiondb::server
