// In-memory state of one database: settings, marker scheme, stored amount, life state, and the
// lifecycle of its model. Users share ownership. The object stays valid after the database is
// deleted; its functions then return NOT_FOUND.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/model/build_settings.h"
#include "core/motion/execution.h"
#include "core/motion/marker_set.h"
#include "server/engine/change_signal.h"
#include "server/engine/database_caches.h"
#include "server/engine/work/engine_options.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"
#include "storage/records.h"

namespace motiondb::server {

class ModelLifecycle;

// How a change behaves while the database is being deleted, which may still fail: it returns
// UNAVAILABLE, or waits for the outcome.
enum class DeletionPolicy { kRefuse, kAwait };

struct WindowTally {
  std::int64_t known = 0;
  std::int64_t unknown = 0;       // core::RecognizedWindow::unknown_probability above 0.5
  std::int64_t uncalibrated = 0;  // without a probability of unknown motion
};

class LiveDatabase : public std::enable_shared_from_this<LiveDatabase> {
 public:
  LiveDatabase(std::string name, const core::BuildSettings& settings);
  ~LiveDatabase();

  const std::string& name() const { return name_; }
  const core::BuildSettings& settings() const { return settings_; }
  // The id in the store (DatabaseRecord); 0 if the store is not shared. Set before it is visible to
  // callers.
  std::int64_t id() const { return id_; }
  void set_id(std::int64_t id) { id_ = id; }

  // The marker scheme of the database; null in a `source` database without clips. DATA_LOSS if the
  // stored scheme could not be read.
  absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme() const;
  void set_scheme(absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme);
  // Replaces the scheme at a time (microseconds since the Unix epoch).
  void ReplaceScheme(std::shared_ptr<const core::MarkerScheme> scheme, std::int64_t time_us);
  // Time of the last replacement; 0: none since the start.
  std::int64_t scheme_time_us() const;

  // What is stored, whether or not in the model. Has all changes that this server acknowledged.
  StoredAmount stored() const;
  // Counts a change after it is stored. Other servers change a shared store too: there it calls
  // Recount, and adds the change only if that fails.
  void CountChange(const StoredAmount& change, storage::AnnotationStore& store);
  // Counts the clips of the newest catalog. Errors of Catalog.
  absl::Status Recount(storage::AnnotationStore& store);
  // Reserves `amount` for a change that is about to be stored, if the quota allows it. Otherwise
  // RESOURCE_EXHAUSTED, with the stored amount and the name of the setting.
  absl::Status Reserve(const StoredAmount& amount, const DatabaseQuota& quota);
  // Called after CountChange, or if nothing was stored.
  void EndReservation(const StoredAmount& amount);

  // Revision that the last look at a shared store has found; 0: the store is not shared.
  std::int64_t seen_revision() const { return seen_revision_; }
  void set_seen_revision(std::int64_t revision) { seen_revision_ = revision; }

  // Open observe streams that use its model; `change` is 1 or -1.
  int open_streams() const { return open_streams_; }
  void AddOpenStreams(int change) { open_streams_ += change; }

  // Answers of Recognize and Observe since the start, one for each window.
  WindowTally recognized_windows() const {
    return {known_windows_, unknown_windows_, uncalibrated_windows_};
  }
  // `unknown_probability`: core::RecognizedWindow::unknown_probability of a window.
  void CountWindow(std::optional<double> unknown_probability) {
    (!unknown_probability         ? uncalibrated_windows_
     : *unknown_probability > 0.5 ? unknown_windows_
                                  : known_windows_)
        .fetch_add(1, std::memory_order_relaxed);
  }

  // Clips with corrupt stored states, and the reason. Models are built without them. Adding a known
  // clip has no effect.
  void AddUnreadable(const std::string& clip, const std::string& what);
  void ForgetUnreadable(const std::string& clip);
  std::map<std::string, std::string> unreadable() const;

  // Clips that could not be derived again (Reprocess), and the reason, which the store keeps too.
  // An empty reason removes the clip.
  void SetDeriveError(const std::string& clip, const std::string& reason);
  std::map<std::string, std::string> underived() const;

  // Notified after each change of the stored data or of the model that answers queries.
  const std::shared_ptr<ChangeSignal>& signal() const { return signal_; }

  // The clips and segments as stored now.
  absl::StatusOr<DatabaseCatalog::Pointer> Catalog(storage::AnnotationStore& store) {
    return catalog_.Current(store, name_);
  }
  FilterMasks& masks() { return masks_; }

  // REQUIRES: SetLifecycle was called.
  ModelLifecycle& lifecycle() const { return *lifecycle_; }
  // Called once, before the database is visible to callers.
  void SetLifecycle(std::unique_ptr<ModelLifecycle> lifecycle);

  // Runs a change of the stored data. Several changes may run at a time. NOT_FOUND if the database
  // is deleted. Calls must not be nested.
  absl::Status WithSharedUse(DeletionPolicy retiring, const std::function<absl::Status()>& change);
  // Waits until running changes end, then runs `deletion` alone. New changes do not start
  // meanwhile, so the deletion is not starved. If `deletion` succeeds, the database is deleted.
  // CANCELLED if cancelled while it waits.
  absl::Status Retire(const std::function<absl::Status()>& deletion,
                      const core::Cancelled& cancelled = {});

  // Held while the scheme changes in the store: by ChangeMarkerScheme, and by the ingest of the
  // first clip of a `source` database, which determines the markers.
  storage::CancellableMutex& scheme_mutex() { return scheme_mutex_; }

 private:
  // OK if the database is neither deleted nor being deleted.
  absl::Status CheckAlive(DeletionPolicy retiring) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string name_;
  const core::BuildSettings settings_;
  std::int64_t id_ = 0;
  const std::shared_ptr<ChangeSignal> signal_ = std::make_shared<ChangeSignal>();
  DatabaseCatalog catalog_;
  FilterMasks masks_;
  std::unique_ptr<ModelLifecycle> lifecycle_;

  mutable storage::Mutex mutex_;
  absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme_ ABSL_GUARDED_BY(mutex_) =
      nullptr;
  std::int64_t scheme_time_us_ ABSL_GUARDED_BY(mutex_) = 0;
  StoredAmount stored_ ABSL_GUARDED_BY(mutex_);
  StoredAmount reserved_ ABSL_GUARDED_BY(mutex_);  // by changes that may not be stored yet
  std::int64_t counted_revision_ ABSL_GUARDED_BY(mutex_) = 0;  // of the catalog in Recount
  std::map<std::string, std::string> unreadable_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> underived_ ABSL_GUARDED_BY(mutex_);
  std::atomic<std::int64_t> seen_revision_{0};
  std::atomic<int> open_streams_{0};
  std::atomic<std::int64_t> known_windows_{0};
  std::atomic<std::int64_t> unknown_windows_{0};
  std::atomic<std::int64_t> uncalibrated_windows_{0};

  enum class Life { kAlive, kRetiring, kDeleted };
  storage::ConditionVariable life_changed_;
  Life life_ ABSL_GUARDED_BY(mutex_) = Life::kAlive;
  int changes_ ABSL_GUARDED_BY(mutex_) = 0;  // running
  storage::CancellableMutex scheme_mutex_;
};

}  // namespace motiondb::server
