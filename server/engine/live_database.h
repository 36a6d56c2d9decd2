// What the server keeps in memory of one database: its settings, its marker scheme, how much is
// stored, whether it is alive, and the lifecycle of its model. Thread-safe. Shared: whoever works
// on a database holds a reference, which stays valid, and says so, after the database was deleted.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/model/build_settings.h"
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"
#include "server/engine/options.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::server {

class ModelLifecycle;

// How much is stored, in the model or not; or how much more or less.
struct StoredAmount {
  std::int32_t clip_count = 0;
  std::int64_t frame_count = 0;
  std::int64_t byte_count = 0;

  StoredAmount operator-() const { return {-clip_count, -frame_count, -byte_count}; }
};

// What one clip adds to it.
inline StoredAmount AmountOf(const storage::ClipRecord& clip) {
  return {1, clip.frame_count, clip.byte_count};
}

// What becomes of a change while the database is being deleted, which may yet fail: it is refused
// with UNAVAILABLE, or waits.
enum class Retiring { kRefuse, kAwait };

class LiveDatabase : public std::enable_shared_from_this<LiveDatabase> {
 public:
  LiveDatabase(std::string name, const core::BuildSettings& settings);
  ~LiveDatabase();

  const std::string& name() const { return name_; }
  const core::BuildSettings& settings() const { return settings_; }

  // The markers that motion is brought to; null in a `source` database without a clip. DATA_LOSS if
  // the stored one could not be read.
  absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme() const;
  void set_scheme(absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme);

  StoredAmount stored() const;
  void AddStored(const StoredAmount& amount);
  // Adds it, unless that would be more than a database may hold: RESOURCE_EXHAUSTED then, saying
  // what there is and which setting it meets.
  absl::Status Reserve(const StoredAmount& amount, const DatabaseQuota& quota);

  // Streams of frames that are judged by its model; `change` is 1 or -1.
  int open_streams() const { return open_streams_; }
  void AddOpenStreams(int change) { open_streams_ += change; }

  // Clips whose stored states are damaged, with what is wrong: models are built without them.
  // Noting one that is known changes nothing.
  void NoteUnreadable(const std::string& clip, const std::string& what);
  void ForgetUnreadable(const std::string& clip);
  std::map<std::string, std::string> unreadable() const;

  // Clips that could not be derived again (Reprocess), with the reason; empty: it could. Kept by
  // the store, too.
  void NoteUnderived(const std::string& clip, const std::string& reason);
  std::map<std::string, std::string> underived() const;

  // Its model. REQUIRES: Serve came before.
  ModelLifecycle& lifecycle() const { return *lifecycle_; }
  // Once, before others find the database.
  void Serve(std::unique_ptr<ModelLifecycle> lifecycle);

  // Runs a change of what is stored, several at a time, but none once the database is deleted:
  // NOT_FOUND then. Not to be nested.
  absl::Status WithSharedUse(Retiring retiring, const std::function<absl::Status()>& change);
  // Runs the deletion itself, alone, when the changes under way have ended; no other
  // begins, so that they cannot keep it from ever coming. If it succeeds, the database is deleted
  // from then on. CANCELLED while it waits for them.
  absl::Status Retire(const std::function<absl::Status()>& deletion,
                      const core::Cancelled& cancelled = {});

  // Held while the first clip of a `source` database is on its way in, for it decides the markers.
  storage::CancellableMutex& first_clip_mutex() { return first_clip_mutex_; }

 private:
  void Add(const StoredAmount& amount) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // OK if the database is neither deleted nor being so.
  absl::Status CheckAlive(Retiring retiring) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string name_;
  const core::BuildSettings settings_;
  std::unique_ptr<ModelLifecycle> lifecycle_;

  mutable storage::Mutex mutex_;
  absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme_ ABSL_GUARDED_BY(mutex_) =
      nullptr;
  StoredAmount stored_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> unreadable_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> underived_ ABSL_GUARDED_BY(mutex_);
  std::atomic<int> open_streams_{0};

  enum class Life { kAlive, kRetiring, kDeleted };
  storage::ConditionVariable life_changed_;
  Life life_ ABSL_GUARDED_BY(mutex_) = Life::kAlive;
  int changes_ ABSL_GUARDED_BY(mutex_) = 0;  // under way
  storage::CancellableMutex first_clip_mutex_;
};

}  // namespace motiondb::server
