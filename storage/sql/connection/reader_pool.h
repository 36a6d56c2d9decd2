// A pool of read connections; each is leased to one thread at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

class ReaderPool {
 public:
  using Open = std::function<absl::StatusOr<std::unique_ptr<Connection>>()>;

  using Check = std::function<absl::Status()>;

  // Opens at most `limit` connections with `open`, on demand. `check` must return OK after each
  // opening; empty: no check.
  ReaderPool(Open open, Check check, int limit);

  // A leased connection. The destructor returns it to the pool, which must outlive the lease.
  class Lease {
   public:
    Lease(ReaderPool& pool, std::unique_ptr<Connection> connection)
        : pool_(&pool), connection_(std::move(connection)) {}
    Lease(Lease&&) = default;
    Lease& operator=(Lease&&) = delete;
    ~Lease() {
      if (connection_ != nullptr) pool_->GiveBack(std::move(connection_));
    }
    Connection& connection() const { return *connection_; }

   private:
    ReaderPool* pool_;
    std::unique_ptr<Connection> connection_;
  };

  // Waits for a connection if all are leased. CANCELLED within about 20 ms after `cancelled`
  // returns true.
  absl::StatusOr<Lease> Acquire(const core::Cancelled& cancelled = {});
  // Returns all connections that are available without waiting except one, which stays for the next
  // caller. They help a caller that already has a connection. May be empty.
  std::vector<Lease> AcquireIdle();

  // Without sessions.
  ConnectionStatistics statistics() const;

 private:
  // Returns an idle connection. Null if none is idle and the caller may open one. CANCELLED.
  absl::StatusOr<std::unique_ptr<Connection>> TakeIdle(const core::Cancelled& cancelled);
  absl::StatusOr<Lease> OpenPromised();
  void GiveBack(std::unique_ptr<Connection> connection);

  const Open open_;
  const Check check_;
  const int limit_;
  mutable Mutex mutex_;
  ConditionVariable given_back_;
  std::vector<std::unique_ptr<Connection>> idle_ ABSL_GUARDED_BY(mutex_);
  int left_to_open_ ABSL_GUARDED_BY(mutex_);
  int waiting_ ABSL_GUARDED_BY(mutex_) = 0;
  std::int64_t waited_ ABSL_GUARDED_BY(mutex_) = 0;
  std::chrono::duration<double> wait_time_ ABSL_GUARDED_BY(mutex_){};
};

}  // namespace motiondb::storage
