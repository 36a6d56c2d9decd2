// Connections that read, lent to one thread at a time. Thread-safe.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "storage/mutex.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/file_identity.h"

namespace motiondb::storage {

class ReaderPool {
 public:
  using Open = std::function<absl::StatusOr<std::unique_ptr<Connection>>()>;

  // Opens connections to `path` with `open` when they are first needed, at most `limit`, and none
  // to another file than `file`, whatever is at `path` by then: UNAVAILABLE.
  ReaderPool(std::string path, FileIdentity file, Open open, int limit);

  // A connection, given back when this is destroyed, which must be before the pool is.
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

  // Waits for a connection if all are lent. CANCELLED, soon after `cancelled` says so.
  absl::StatusOr<Lease> Acquire(const core::Cancelled& cancelled = {});
  // Those that are to be had without waiting, to help one that was acquired; but one stays for
  // whoever asks next. May be none.
  std::vector<Lease> AcquireIdle();

 private:
  // Null if there is none idle and one may be opened. CANCELLED.
  absl::StatusOr<std::unique_ptr<Connection>> TakeIdle(const core::Cancelled& cancelled);
  absl::StatusOr<Lease> OpenPromised();
  void GiveBack(std::unique_ptr<Connection> connection);

  const std::string path_;
  const FileIdentity file_;
  const Open open_;
  Mutex mutex_;
  ConditionVariable given_back_;
  std::vector<std::unique_ptr<Connection>> idle_ ABSL_GUARDED_BY(mutex_);
  int left_to_open_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::storage
