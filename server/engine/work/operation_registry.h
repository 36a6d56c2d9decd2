// Registry of operations. Each operation is a row in the store. Unfinished operations are also kept
// in memory, with their detailed progress and watchers. An operation that cannot be stored, for
// example on a full disk, is kept in memory only and logged once; the work it represents continues.
// A later change of it may be stored. Callbacks run on the thread that ends an operation, without a
// lock held.
//
// If several servers share the store, an operation is never kept in memory only: no other server
// would know it. A change that cannot be stored returns the error of the store. Each server keeps
// the unfinished operations of all in memory, as Follow saw them last, for waits; Get and List read
// the store, except for the progress of operations that run on this server.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

class OperationRegistry {
 public:
  using Watcher = std::function<void(const storage::OperationRecord&)>;

  // The store must outlive the registry.
  explicit OperationRegistry(storage::MotionStore& store)
      : store_(store), is_shared_(store.is_shared()) {}

  // Creates a PENDING operation and tries to store it. Ids are unique across restarts and ascend
  // with time. NOT_FOUND, here and in Adopt, if the database does not exist; ABORTED if another one
  // than that with `database_id` (0: any) has its name. CANCELLED, here and in
  // Cancel, with nothing changed, if cancelled before it was stored.
  absl::StatusOr<storage::OperationRecord> Create(
      const std::string& database, const core::Cancelled& cancelled = {},
      storage::OperationKind kind = storage::OperationKind::kRebuild, std::int64_t database_id = 0);
  // Resumes an unfinished operation of a previous server: it becomes PENDING.
  absl::StatusOr<storage::OperationRecord> Adopt(storage::OperationRecord record);

  // NOT_FOUND.
  absl::StatusOr<storage::OperationRecord> Get(const std::string& id);
  // Like MotionStore::ListOperations, with the current progress of running operations. Operations
  // that could not be stored are not listed.
  absl::StatusOr<std::vector<storage::OperationRecord>> List(const std::string& database,
                                                             const std::string& before, int limit);

  // PENDING -> RUNNING, on this server. Returns false if another server has ended the operation.
  bool Start(const std::string& id);
  // Sets the progress of a running operation, in memory only, so frequent calls are cheap.
  void Advance(const std::string& id, double progress, std::string_view stage);
  // RUNNING -> PENDING: the next server resumes it.
  void Postpone(const std::string& id);
  // Stores nothing: another server has taken over the operation.
  void HandOver(const std::string& id);
  // To a final state, unless it has ended: results never change. CANCELLED if its database was
  // deleted. Of a shared store, an error of it: the operation has not ended.
  // `model_version` 0: no clip was left to build from. The stage becomes "done",
  // followed by `remark`.
  absl::Status Succeed(const std::string& id, int model_version, const std::string& remark = "");
  absl::Status Fail(const std::string& id, const absl::Status& error);
  absl::Status Cancel(const std::string& id, const core::Cancelled& cancelled = {});
  // The same for an operation that may be another server's, which then stops it. Returns false if
  // it has already ended.
  absl::StatusOr<bool> CancelAnywhere(const std::string& id, const core::Cancelled& cancelled = {});
  // Takes over what other servers have changed. `unfinished`: as MotionStore lists them.
  void Follow(const std::vector<storage::OperationRecord>& unfinished);
  // Its row was deleted with its database: CANCELLED, in memory only. In a shared store it may be
  // an operation of a new database with the name: Follow finds it.
  void Abandon(const std::string& id);

  // Calls `watcher` once with the operation, when it is done or EndWaits is called. Returns a
  // key for Unwatch. Returns 0, without a call, if that has already happened.
  std::uint64_t Watch(const std::string& id, Watcher watcher);
  void Unwatch(const std::string& id, std::uint64_t key);
  // For shutdown: ends all current and future waits.
  void EndWaits();

 private:
  struct Live {
    storage::OperationRecord record;
    std::map<std::uint64_t, Watcher> watchers;
    bool stored = true;    // whether the last durable change was stored
    bool is_here = false;  // whether it runs on this server
  };
  enum class Durability { kStored, kInMemory };

  absl::StatusOr<storage::OperationRecord> Add(storage::OperationRecord record,
                                               const core::Cancelled& cancelled);
  // Returns OK, CANCELLED, or an error of a shared store; after an error, nothing changed.
  absl::Status Change(const std::string& id, Durability durability,
                      const std::function<void(storage::OperationRecord&)>& change,
                      const core::Cancelled& cancelled = {});
  // Sets the record of an operation that does not run here to the stored one.
  void Observe(const storage::OperationRecord& stored);
  // Whether the record in memory is as new as the stored one.
  bool IsNewest(const Live& live) const { return !is_shared_ || live.is_here || !live.stored; }

  storage::MotionStore& store_;
  const bool is_shared_;
  storage::Mutex mutex_;
  std::map<std::string, Live> live_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t next_key_ ABSL_GUARDED_BY(mutex_) = 1;
  bool released_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace motiondb::server
