// The server without its transport: databases, their models and the operations that rebuild them,
// on top of a store. Knows no gRPC. Thread-safe; owns the store and all threads.
//
// A database is named by its id alone here, without "databases/".
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/engine/damage_book.h"
#include "server/engine/ingest.h"
#include "server/engine/live_database.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/model_lifecycle.h"
#include "server/engine/operation_registry.h"
#include "server/engine/options.h"
#include "server/engine/skeleton_cache.h"
#include "server/engine/workers.h"
#include "storage/cancellable_lock.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

// How much a store holds.
struct StoreAmount {
  std::int32_t database_count = 0;
  std::int64_t clip_count = 0;
};

struct Ingested {
  storage::ClipRecord clip;
  storage::OperationRecord operation;
};

struct Cancellation {
  storage::OperationRecord operation;  // as it then stands
  bool is_first = false;               // false: it was over, or was to stop, before this
};

class Engine {
 public:
  // Reads the stored models, without building any, and takes up what a former server left undone. A
  // model that cannot be read, or was built from other clips than there are, is rebuilt. What is
  // damaged is left out and told by damages(); the rest is served. Nothing has to be written for
  // it.
  static absl::StatusOr<std::unique_ptr<Engine>> Open(std::unique_ptr<storage::MotionStore> store,
                                                      const EngineOptions& options);
  ~Engine();

  // For what needs no more than to be read.
  storage::MotionStore& store() { return *store_; }
  OperationRegistry& operations() { return operations_; }
  Workers& workers() { return workers_; }
  SkeletonCache& skeletons() { return skeletons_; }
  const EngineOptions& options() const { return options_; }

  // Changes take their entry of the record of changes along to the store; null: there is none.
  // ALREADY_EXISTS, RESOURCE_EXHAUSTED.
  absl::StatusOr<storage::DatabaseRecord> CreateDatabase(const std::string& database,
                                                         const core::BuildSettings& settings,
                                                         const MarkerSetSetting& marker_set,
                                                         const storage::ChangeTerms& terms = {});
  // With its clips, models and operations; what runs for it stops.
  absl::Status DeleteDatabase(const std::string& database, const storage::ChangeTerms& terms = {});
  // NOT_FOUND.
  absl::StatusOr<std::shared_ptr<LiveDatabase>> FindDatabase(const std::string& database);

  // All, in order of name.
  std::vector<std::shared_ptr<LiveDatabase>> Databases();

  // The rebuild that waits or works for a database, as it stands; nothing where there is none.
  std::optional<storage::OperationRecord> CurrentOperation(const LiveDatabase& database);

  // The model that answers queries now. FAILED_PRECONDITION, saying what to do, if there is none.
  absl::StatusOr<std::shared_ptr<const Snapshot>> CurrentModel(const LiveDatabase& database);

  // Announces an ingest, for as long as the result lives, so that a rebuild waits for it.
  absl::StatusOr<std::unique_ptr<ModelLifecycle::Ingest>> BeginIngest(
      const std::shared_ptr<LiveDatabase>& database);
  // See IngestClip; with the rebuild that will make the clip known. CANCELLED also, here and of
  // DeleteClip, where the change was made but the rebuild not yet asked for: it will be.
  absl::StatusOr<Ingested> Ingest(const std::shared_ptr<LiveDatabase>& database, IngestFile file,
                                  const WorkTerms& terms);
  // Returns the rebuild that takes the clip out of the model. NOT_FOUND, UNAVAILABLE (here and of
  // CancelOperation: the database is being deleted).
  absl::StatusOr<storage::OperationRecord> DeleteClip(const std::string& database,
                                                      const std::string& clip,
                                                      const storage::ChangeTerms& terms = {});
  // Has all clips of a database derived again from their files, then its model rebuilt. NOT_FOUND,
  // UNAVAILABLE (as above). CANCELLED, with nothing changed.
  absl::StatusOr<storage::OperationRecord> ReprocessDatabase(const std::string& database,
                                                             const core::Cancelled& cancelled = {});
  // NOT_FOUND. CANCELLED, with nothing changed.
  absl::StatusOr<Cancellation> CancelOperation(const std::string& operation,
                                               const core::Cancelled& cancelled = {});

  // Keeps an entry of the record of changes of a call that cannot wait until it is written.
  void RecordLater(const storage::AuditRecord& record);

  // What was found damaged since the start, at most a hundred things.
  std::vector<storage::Damage> damages();
  // For what finds damage elsewhere.
  void NoteDamage(const storage::Damage& damage) { damages_.Note(damage); }

  // Takes over a backup that has come in whole and serves what it brings, each database once its
  // model is read. CANCELLED, with nothing changed; and the codes of StoreRestore.
  absl::StatusOr<StoreAmount> Restore(storage::StoreRestore& restore,
                                      const core::Cancelled& cancelled);

  // Stops builds, whose operations stay PENDING for the next server, and ends all waiting for
  // operations. Queries go on.
  void Drain();

 private:
  Engine(std::unique_ptr<storage::MotionStore> store, const EngineOptions& options);
  std::size_t database_count();
  // Frees what deleted databases left, on the thread for upkeep, in the breaks of its other work.
  void FreeDeletedDatabases();
  std::shared_ptr<LiveDatabase> Serve(const std::string& name, const core::BuildSettings& settings);
  // By name.
  using LiveDatabases = std::map<std::string, std::shared_ptr<LiveDatabase>>;
  // Brings what is stored to life, then lets others find it.
  absl::StatusOr<StoreAmount> Load();
  absl::Status ReadDatabases(LiveDatabases& databases);
  absl::Status ReadDatabase(LiveDatabase& live, const storage::DatabaseRecord& record);
  absl::Status ResumeOperations(const LiveDatabases& databases);
  absl::Status RebuildWhereNeeded(const LiveDatabases& databases);

  const EngineOptions options_;
  const std::unique_ptr<storage::MotionStore> store_;
  OperationRegistry operations_;
  DamageBook damages_;
  SkeletonCache skeletons_;
  MarkerSchemes schemes_;
  Workers workers_;

  std::atomic<bool> freeing_waits_{false};  // for the thread for upkeep
  std::atomic<bool> draining_{false};

  // Held over creating and deleting, which may be long; mutex_ only guards the map.
  storage::CancellableMutex naming_mutex_;
  storage::Mutex mutex_;
  LiveDatabases databases_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
