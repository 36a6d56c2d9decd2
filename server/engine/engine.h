// The server without its transport: databases, their models and the operations that rebuild them,
// on top of a store. Does not depend on gRPC. Owns the store and all threads.
//
// Databases are identified by id, without the prefix "databases/".
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/engine/database_caches.h"
#include "server/engine/ingest.h"
#include "server/engine/live_database.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operator_log.h"
#include "server/engine/request_checks.h"
#include "server/engine/snapshot.h"
#include "server/engine/work/engine_options.h"
#include "server/engine/work/operation_registry.h"
#include "server/engine/work/workers.h"
#include "storage/annotation_store.h"
#include "storage/cancellable_lock.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Contents of a store.
struct StoreCounts {
  std::int32_t database_count = 0;
  std::int64_t clip_count = 0;
};

struct Ingested {
  storage::ClipRecord clip;
  storage::OperationRecord operation;
};

// A stored edit.
struct Edited {
  storage::EditRecord edit;   // id 0: without effect
  std::int64_t revision = 0;  // of the database, with the edit
  // The operation that fits the model; none if neither labels nor subjects changed.
  std::optional<storage::OperationRecord> operation;
};

struct Cancellation {
  storage::OperationRecord operation;  // state after the call
  bool is_first = false;               // false: it was already done or stopping
};

class Engine {
 public:
  // Reads the stored models, without building any, and resumes the operations that the previous
  // server did not finish. Rebuilds a model that cannot be read or is out of date with the stored
  // clips. Corrupt parts are left out and listed by corruptions(); the rest is served. Does not
  // need to write to the store.
  static absl::StatusOr<std::unique_ptr<Engine>> Open(std::unique_ptr<storage::MotionStore> store,
                                                      const EngineOptions& options);
  ~Engine();

  // For reads. Changes go through the functions below.
  storage::MotionStore& store() { return *store_; }
  OperationRegistry& operations() { return operations_; }
  Workers& workers() { return workers_; }
  SkeletonCache& skeletons() { return skeletons_; }
  const EngineOptions& options() const { return options_; }
  // Name of this server among those of the store: eight digits.
  std::string name() const { return name_.substr(name_.rfind('/') + 1); }

  // The audit log entry in `terms` is stored in the same transaction as the change; null: no entry.
  // ALREADY_EXISTS, RESOURCE_EXHAUSTED; INVALID_ARGUMENT of core::CheckSettings, below `database`.
  absl::StatusOr<storage::DatabaseRecord> CreateDatabase(const std::string& database,
                                                         const core::BuildSettings& settings,
                                                         const MarkerSetSetting& marker_set,
                                                         const storage::WriteOptions& terms = {});
  // Deletes the database with its clips, models and operations, and stops its running build.
  absl::Status DeleteDatabase(const std::string& database, const storage::WriteOptions& terms = {});
  // Replaces the marker scheme of a database by `change` of it, for later input. NOT_FOUND,
  // UNAVAILABLE (while the database is being deleted); FAILED_PRECONDITION without a scheme;
  // RESOURCE_EXHAUSTED if the new one is too long; errors of `change`.
  using SchemeChange = std::function<absl::StatusOr<core::MarkerScheme>(const core::MarkerScheme&)>;
  absl::Status ChangeMarkerScheme(const std::string& database, const SchemeChange& change,
                                  const storage::WriteOptions& terms = {});
  // NOT_FOUND. Of a shared store also UNAVAILABLE: it is not known whether the database exists.
  absl::StatusOr<std::shared_ptr<LiveDatabase>> FindDatabase(const std::string& database);

  // All databases, ordered by name.
  std::vector<std::shared_ptr<LiveDatabase>> Databases();

  // Returns the pending or running rebuild of a database; nullopt if there is none.
  std::optional<storage::OperationRecord> CurrentOperation(const LiveDatabase& database);

  // Returns the model that answers queries now. FAILED_PRECONDITION, with a hint what to do, if
  // there is none.
  // AwaitsChange if it is read from the store first; see WorkOptions::wake_on.
  absl::StatusOr<SnapshotPointer> CurrentModel(const LiveDatabase& database,
                                               const WorkOptions& terms = {});
  // The same, with the revision that it contains.
  absl::StatusOr<ServedModel> CurrentModelAndRevision(const LiveDatabase& database,
                                                      const WorkOptions& terms = {});
  // Returns null instead of FAILED_PRECONDITION.
  absl::StatusOr<SnapshotPointer> ModelIfAny(const LiveDatabase& database,
                                             const WorkOptions& terms = {});

  // Marks an ingest as in flight for the lifetime of the result. A rebuild waits for it.
  absl::StatusOr<std::unique_ptr<ModelLifecycle::Ingest>> BeginIngest(
      const std::shared_ptr<LiveDatabase>& database);
  // See IngestClip. Also returns the rebuild that will add the clip to the model; empty for
  // validate_only. CANCELLED also if the change was stored but the rebuild was not yet requested,
  // here and in DeleteClip; the rebuild is then requested in the background.
  absl::StatusOr<Ingested> Ingest(const std::shared_ptr<LiveDatabase>& database,
                                  IngestRequest request, const WorkOptions& terms);
  // Returns the rebuild that removes the clip from the model. NOT_FOUND; UNAVAILABLE, here and in
  // CancelOperation, while the database is being deleted.
  absl::StatusOr<storage::OperationRecord> DeleteClip(const std::string& database,
                                                      const std::string& clip,
                                                      const storage::WriteOptions& terms = {});
  // Edits clips and segments; see AnnotationStore::Edit and UndoEdit. Changed labels are in answers
  // soon, with the metric and calibration of the former labels; the operation refits these.
  // UNAVAILABLE as above; INVALID_ARGUMENT of CheckChanges.
  absl::StatusOr<Edited> Edit(const std::string& database, std::span<const storage::Change> changes,
                              const std::string& author, const storage::WriteOptions& terms = {},
                              EditFields fields = EditFields::kOneChange);
  absl::StatusOr<Edited> UndoEdit(const std::string& database, std::int64_t edit,
                                  const std::string& author,
                                  const storage::WriteOptions& terms = {});
  // Derives the states of all clips again from their files, then rebuilds the model. NOT_FOUND,
  // UNAVAILABLE (as above). CANCELLED, with nothing changed.
  absl::StatusOr<storage::OperationRecord> ReprocessDatabase(const std::string& database,
                                                             const core::Cancelled& cancelled = {});
  // NOT_FOUND. CANCELLED, with nothing changed.
  absl::StatusOr<Cancellation> CancelOperation(const std::string& operation,
                                               const core::Cancelled& cancelled = {});

  // Stores an audit log entry in the background, for a call that cannot wait until it is written.
  void RecordLater(const storage::AuditRecord& record);

  // Corruption found since the start, at most CorruptionLog::kLimit entries.
  std::vector<storage::Corruption> corruptions();
  // For callers outside the engine that find corruption.
  void ReportCorruption(const storage::Corruption& corruption) { corruptions_.Note(corruption); }

  // Imports a completely received backup and serves its databases. Each database becomes visible
  // after its model is read. CANCELLED, with nothing changed; also the codes of StoreRestore.
  absl::StatusOr<StoreCounts> Restore(storage::StoreRestore& restore,
                                      const core::Cancelled& cancelled);

  // Adds an exported database that `import` has checked, as `database`, and serves it. It becomes
  // visible after its model is read. ALREADY_EXISTS, RESOURCE_EXHAUSTED (a quota); CANCELLED; also
  // the codes of DatabaseImport. An error changes nothing.
  absl::Status ImportDatabase(std::unique_ptr<storage::DatabaseImport> import,
                              const storage::ExportedDatabase& content, const std::string& database,
                              const storage::WriteOptions& terms);
  // The same errors, as far as they are known without the content. A later import can still fail.
  absl::Status CheckMayImport(const std::string& database);

  // If several servers share the store, the engine looks every second, and soon after the store has
  // notified a change, at what the others have changed: databases, clips, models and operations.
  // LookNow does it soon too.
  void LookNow();
  // Time since the begin of the last successful look; 0 if the store is not shared.
  double SecondsSinceLook();
  // Calls `follower` with a look, at most every second, until Drain. Called before calls are
  // served.
  void AddFollower(std::function<void()> follower);

  // Stops builds and ends all waits for operations. Stopped operations stay PENDING for the next
  // server. Queries continue.
  void Drain();

 private:
  Engine(std::unique_ptr<storage::MotionStore> store, const EngineOptions& options);
  // RESOURCE_EXHAUSTED if there is no room for another database.
  absl::Status CheckDatabaseCount();
  // Frees the storage of deleted databases on the maintenance thread. Yields to its other work.
  void FreeDeletedDatabases();
  // Makes an edit with the options, to which the id of the database is added.
  using EditStore =
      std::function<absl::StatusOr<storage::EditRecord>(const storage::WriteOptions& terms)>;
  absl::StatusOr<Edited> StoreEdit(const std::string& database, const EditStore& edit,
                                   const storage::WriteOptions& terms);
  std::shared_ptr<LiveDatabase> Serve(const storage::DatabaseRecord& record);
  // Key: database name.
  using LiveDatabases = std::map<std::string, std::shared_ptr<LiveDatabase>>;
  // Evicts the models that were not used for the longest time, until a further one of this size
  // fits. The last used one stays.
  void MakeRoom(std::int64_t bytes);
  // Creates the live databases from the store, then makes them visible to callers.
  absl::StatusOr<StoreCounts> Load();
  // Null: it is not visible.
  std::shared_ptr<LiveDatabase> FindServed(const std::string& database);
  // Makes databases visible to callers.
  void Show(LiveDatabases& databases);
  // Publishes a staged database and serves it.
  absl::Status PublishImport(storage::DatabaseImport& import,
                             const storage::ExportedDatabase& content, const std::string& database,
                             const storage::WriteOptions& terms);
  absl::Status ReadDatabases(LiveDatabases& databases);
  absl::Status ReadDatabase(LiveDatabase& live, const storage::DatabaseRecord& record);
  absl::Status ResumeOperations(const LiveDatabases& databases);
  absl::Status RebuildOutdated(const LiveDatabases& databases);

  // What other servers change (follow_store.cc).
  void FollowStore();
  void StopFollowing();
  void Look();
  absl::Status LookAtStore() ABSL_EXCLUSIVE_LOCKS_REQUIRED(look_mutex_);
  // Adds the names of the databases that have changed since the last look; before an error, those
  // that it has followed.
  absl::Status FollowDatabases(std::set<std::string>& changed)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(look_mutex_);
  // A database as the last look saw it.
  struct SeenDatabase {
    storage::DatabaseState state;
    std::string marker_set_text;
  };
  // Serves a database that another server has created since the last look. NOT_FOUND; UNAVAILABLE.
  absl::Status LookFor(const std::string& database);
  // An error changes nothing: the next look tries again.
  absl::Status FollowDatabase(const storage::DatabaseState& state)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(look_mutex_);
  // Another server has deleted the database. Returns false if running changes take too long; the
  // next look tries again.
  bool DropDatabase(const std::shared_ptr<LiveDatabase>& live);

  // Reads the markers of a database without any: a clip on another server may have brought them.
  absl::Status ReadScheme(LiveDatabase& database);

  const EngineOptions options_;
  const std::string name_;  // of this server, in build leases
  const std::unique_ptr<storage::MotionStore> store_;
  OperationRegistry operations_;
  CorruptionLog corruptions_;
  SkeletonCache skeletons_;
  MarkerSchemes schemes_;
  Workers workers_;

  std::atomic<bool> purge_queued_{false};  // on the maintenance thread
  std::atomic<bool> draining_{false};

  // Held while a database is created or deleted, which may take long. mutex_ only guards the map.
  storage::CancellableMutex naming_mutex_;
  storage::Mutex mutex_;
  LiveDatabases databases_ ABSL_GUARDED_BY(mutex_);

  storage::Mutex wake_mutex_;
  std::unique_ptr<Executor::Timer> wake_
      ABSL_GUARDED_BY(wake_mutex_);                      // of the look after a change
  bool is_waking_ ABSL_GUARDED_BY(wake_mutex_) = false;  // whether it is set
  std::unique_ptr<storage::StoreWatch> watch_;           // from FollowStore to StopFollowing

  std::atomic<Executor::Clock::time_point> last_look_{};  // that succeeded; epoch: never
  storage::Mutex look_mutex_;                             // held while the engine looks
  std::unique_ptr<Executor::Timer> next_look_ ABSL_GUARDED_BY(look_mutex_);
  std::map<std::string, SeenDatabase> seen_ ABSL_GUARDED_BY(look_mutex_);
  std::vector<std::function<void()>> followers_ ABSL_GUARDED_BY(look_mutex_);
  Executor::Clock::time_point next_follow_ ABSL_GUARDED_BY(look_mutex_);  // call of the followers
  Executor::Clock::time_point next_purge_ ABSL_GUARDED_BY(look_mutex_);
  bool sees_store_ ABSL_GUARDED_BY(look_mutex_) = true;  // whether the last look succeeded
};

}  // namespace motiondb::server
