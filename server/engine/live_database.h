// What the server keeps in memory of one database: its settings, its marker scheme and the model
// that answers queries. Thread-safe. Shared: whoever works on a database holds a reference, which
// stays valid, and says so, after the database was deleted.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "core/model/build_settings.h"
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"
#include "server/engine/options.h"
#include "storage/records.h"

namespace motiondb::server {

class ModelLifecycle;
struct Snapshot;

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

// How the rebuilds since the start ended, and how long they took together.
struct RebuildTally {
  std::int64_t succeeded = 0;
  std::int64_t failed = 0;
  std::int64_t cancelled = 0;  // by a caller, or because the server stops
  double seconds = 0;
};

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

  // The current model; null while there is none.
  std::shared_ptr<const Snapshot> snapshot() const;
  void set_snapshot(std::shared_ptr<const Snapshot> snapshot);

  StoredAmount stored() const;
  void AddStored(const StoredAmount& amount);
  // Adds it, unless that would be more than a database may hold: RESOURCE_EXHAUSTED then, saying
  // what there is and which setting it meets.
  absl::Status Reserve(const StoredAmount& amount, const DatabaseQuota& quota);

  RebuildTally rebuilds() const;
  // Counts a rebuild under one of the tally's outcomes.
  void CountRebuild(std::int64_t RebuildTally::*outcome, double seconds);

  // Streams of frames that are judged by its model; `change` is 1 or -1.
  int open_streams() const { return open_streams_; }
  void AddOpenStreams(int change) { open_streams_ += change; }

  // Clips whose stored states are damaged, with what is wrong: models are built without them.
  // Noting one that is known changes nothing.
  void NoteUnreadable(const std::string& clip, const std::string& what);
  void ForgetUnreadable(const std::string& clip);
  std::map<std::string, std::string> unreadable() const;

  // When its model is built and extended. REQUIRES: Serve came before.
  ModelLifecycle& lifecycle() { return *lifecycle_; }
  // Once, before others find the database.
  void Serve(std::unique_ptr<ModelLifecycle> lifecycle);

  // The operation of the rebuild that waits or works; empty: none. Set by the lifecycle, read
  // without waiting for it.
  std::string operation() const;
  void set_operation(std::string operation);

  // Runs a change of what is stored, several at a time, but none once the database is deleted:
  // NOT_FOUND then. Not to be nested.
  absl::Status WhileAlive(Retiring retiring, const std::function<absl::Status()>& change);
  // Runs the deletion itself, alone, when the changes under way have ended; no other
  // begins, so that they cannot keep it from ever coming. If it succeeds, the database is deleted
  // from then on. CANCELLED while it waits for them.
  absl::Status Retire(const std::function<absl::Status()>& deletion,
                      const core::Cancelled& cancelled = {});

  // Held from reading the current model, in the store or here, to putting the next one, so that
  // neither a build nor an extension is lost. Taken before WhileAlive.
  std::mutex& model_mutex() { return model_mutex_; }

  // Held by a build from its beginning to its end, and by who removes what deleted clips leave.
  // Taken before the model's; within WhileAlive it may be tried, but not waited for.
  std::mutex& states_mutex() { return states_mutex_; }

  // Held while the first clip of a `source` database is on its way in, for it decides the markers.
  std::timed_mutex& first_clip_mutex() { return first_clip_mutex_; }

 private:
  // REQUIRES: mutex_ is held.
  void Add(const StoredAmount& amount);
  // OK if the database is neither deleted nor being so.
  absl::Status CheckAlive(Retiring retiring, std::unique_lock<std::mutex>& life_lock);

  const std::string name_;
  const core::BuildSettings settings_;
  std::unique_ptr<ModelLifecycle> lifecycle_;

  mutable std::mutex mutex_;
  absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme_ = nullptr;
  std::shared_ptr<const Snapshot> snapshot_;
  StoredAmount stored_;
  RebuildTally rebuilds_;
  std::map<std::string, std::string> unreadable_;
  std::string operation_;
  std::atomic<int> open_streams_{0};

  enum class Life { kAlive, kRetiring, kDeleted };
  std::mutex life_mutex_;
  std::condition_variable life_changed_;
  Life life_ = Life::kAlive;
  int changes_ = 0;  // under way
  std::mutex states_mutex_;
  std::mutex model_mutex_;
  std::timed_mutex first_clip_mutex_;
};

}  // namespace motiondb::server
