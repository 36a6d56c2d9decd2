// The operations: each is a row in the store, and those not done are kept here too, with their fine
// progress and those who wait for them. One that cannot be stored, on a full disk for example, is
// kept here alone, and the log says so once: what it stands for has happened or goes on all the
// same. A later change of it may be stored. Thread-safe. Callbacks run on the thread that ends an
// operation, without a lock held.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

class OperationRegistry {
 public:
  using Watcher = std::function<void(const storage::OperationRecord&)>;

  // The store must outlive the registry.
  explicit OperationRegistry(storage::MotionStore& store) : store_(store) {}

  // A new PENDING operation, stored if it can be. Ids are unique over restarts and ascend with
  // time. NOT_FOUND, here and of Adopt, if there is no such database. CANCELLED, here and of
  // Cancel, with nothing changed, where it was cancelled before its turn to be stored.
  absl::StatusOr<storage::OperationRecord> Create(
      const std::string& database, const core::Cancelled& cancelled = {},
      storage::OperationKind kind = storage::OperationKind::kRebuild);
  // Takes up an operation that a former server left undone: it is PENDING again.
  absl::StatusOr<storage::OperationRecord> Adopt(storage::OperationRecord record);

  // NOT_FOUND if there is none of that id.
  absl::StatusOr<storage::OperationRecord> Get(const std::string& id);
  // As MotionStore::ListOperations, of those that could be stored, with the progress of those at
  // work.
  absl::StatusOr<std::vector<storage::OperationRecord>> List(const std::string& database,
                                                             const std::string& before, int limit);

  // PENDING -> RUNNING.
  void Start(const std::string& id);
  // Progress of a running one. Kept in memory only: it may be told a thousand times.
  void Advance(const std::string& id, double progress, std::string_view stage);
  // RUNNING -> PENDING: a later server takes it up.
  void Postpone(const std::string& id);
  // To a final state. `model_version` 0: no clip was left to build from. The stage is then "done",
  // and what there is to say about it.
  void Succeed(const std::string& id, int model_version, const std::string& remark = "");
  void Fail(const std::string& id, const absl::Status& error);
  absl::Status Cancel(const std::string& id, const core::Cancelled& cancelled = {});
  // CANCELLED, in memory only: its database is about to go, and its row with it.
  void Abandon(const std::string& id);

  // Calls `watcher` once, with the operation as it then stands, when it is done or waiting has no
  // more sense (see ReleaseWaiters). Returns a key for Unwatch, or 0, without calling, if that is
  // so already.
  std::uint64_t Watch(const std::string& id, Watcher watcher);
  void Unwatch(const std::string& id, std::uint64_t key);
  // The server is about to stop: ends all waiting, now and from now on.
  void ReleaseWaiters();

 private:
  struct Live {
    storage::OperationRecord record;
    std::map<std::uint64_t, Watcher> watchers;
    bool stored = true;  // as of its last change that was to be
  };
  enum class Durability { kStored, kInMemory };

  absl::StatusOr<storage::OperationRecord> Add(storage::OperationRecord record,
                                               const core::Cancelled& cancelled);
  // CANCELLED is all that keeps it from being made.
  absl::Status Change(const std::string& id, Durability durability,
                      const std::function<void(storage::OperationRecord&)>& change,
                      const core::Cancelled& cancelled = {});

  storage::MotionStore& store_;
  storage::Mutex mutex_;
  std::map<std::string, Live> live_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t next_key_ ABSL_GUARDED_BY(mutex_) = 1;
  bool released_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace motiondb::server
