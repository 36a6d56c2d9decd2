// Interface of the storage of databases, clips, models and operations. One conformance suite
// (tests/storage) runs on every implementation.
//
// Thread-safe. A call that changes something is atomic and returns only when the change is durable.
// The caller checks names; a store accepts any non-empty string. Codes of all calls: NOT_FOUND (a
// named object does not exist), ALREADY_EXISTS, DATA_LOSS (stored bytes are corrupt; the message
// names them), UNAVAILABLE or RESOURCE_EXHAUSTED (disk).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/access_store.h"
#include "storage/annotation_store.h"
#include "storage/records.h"
#include "storage/store_maintenance.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::storage {

// One page of a list in ascending order of its key: at most `limit` (positive) items with a key
// above `after` (empty: from the start).
struct Page {
  std::string after;
  int limit = 100;
};

// Number of failed writes since the store was opened, by cause.
struct WriteFailures {
  std::int64_t no_space = 0;    // out of disk space or memory
  std::int64_t io_error = 0;    // disk error, or the file is missing or read-only
  std::int64_t corruption = 0;  // stored bytes cannot be read
  std::int64_t other = 0;

  std::int64_t total() const { return no_space + io_error + corruption + other; }
};

// The connections of a store at one moment.
struct ConnectionStatistics {
  int max_readers = 0;   // of reads at the same time; 0: reads wait for writes
  int open_readers = 0;  // connections that read
  int leased_readers = 0;
  int waiting_reads = 0;
  // Since the store was opened:
  std::int64_t waited_reads = 0;     // reads that have waited for a connection
  double wait_seconds = 0;           // their sum
  std::int64_t opened_sessions = 0;  // of PostgreSQL, to read and to write
  std::int64_t failed_sessions = 0;  // attempts to open one
};

// Returns ALREADY_EXISTS for a clip that is stored as `same`, by content or id.
absl::Status SameClipError(const ClipRecord& same, const NewClip& clip);

// Wakes a server soon after another server has changed the store that they share.
struct StoreChange {
  // The changed database. Empty: something else may have changed (tokens, operations, the list of
  // databases), or notifications were lost.
  std::string database;
  std::int64_t revision = 0;  // of the database, after the change; 0: not known
};

// Runs on a thread of the store: it must return soon, and must not call the store or destroy the
// watch. It must not throw.
using OnStoreChange = std::function<void(const StoreChange&)>;

// As long as it exists, changes are notified. The destructor waits for a running call. Must be
// destroyed before the store.
class StoreWatch {
 public:
  StoreWatch() = default;
  virtual ~StoreWatch() = default;
  StoreWatch(const StoreWatch&) = delete;
  StoreWatch& operator=(const StoreWatch&) = delete;
};

class MotionStore {
 public:
  virtual ~MotionStore() = default;

  // Returns whether several servers may use the store at the same time.
  virtual bool is_shared() const { return false; }

  // Databases, listed in order of name.
  virtual absl::Status CreateDatabase(const DatabaseRecord& record,
                                      const WriteOptions& terms = {}) = 0;
  virtual absl::StatusOr<DatabaseRecord> GetDatabase(const std::string& database) = 0;
  virtual absl::StatusOr<std::vector<DatabaseRecord>> ListDatabases(const Page& page) = 0;
  // Replaces the marker_set_text of a database. ABORTED if it is not `before`.
  virtual absl::Status ReplaceMarkerSet(const std::string& database, const std::string& before,
                                        const std::string& text,
                                        const WriteOptions& terms = {}) = 0;
  // Deletes a database with its content. It is invisible to other calls immediately, and its name
  // can be reused. PurgeDeletedDatabases frees its disk space.
  virtual absl::Status DeleteDatabase(const std::string& database,
                                      const WriteOptions& terms = {}) = 0;
  // Returns the states of all databases, in order of name. One cheap query.
  virtual absl::StatusOr<std::vector<DatabaseState>> ListDatabaseStates() = 0;
  // Frees the content of deleted databases in many short transactions; other writes run between
  // them. Only one call at a time; other functions may run concurrently. CANCELLED if `cancelled`
  // returns true; the next call continues. DATA_LOSS if some content cannot be read and stays; the
  // rest is removed.
  virtual absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) = 0;

  // Clips, listed in order of id. AddClip returns the record as stored. If the requested id exists,
  // it appends "-2", "-3", ..., unless id_is_fixed. ALREADY_EXISTS, naming the clip, if the same
  // content is stored already or a fixed id exists. INVALID_ARGUMENT if the record's frame_count
  // differs from the number of states. FAILED_PRECONDITION if the clip brings a marker set and the
  // database has a different one. ABORTED if the database is not the one with `clip.database_id`.
  virtual absl::StatusOr<ClipRecord> AddClip(const NewClip& clip) = 0;
  // Returns the stored clip for which AddClip returns ALREADY_EXISTS: with the same content, or
  // with the fixed id. NOT_FOUND if there is none.
  virtual absl::StatusOr<ClipRecord> FindSameClip(const NewClip& clip) = 0;
  // Deletes the clip `before` and adds `clip`, in one transaction. The clip keeps its segments and
  // those annotations that `clip` does not have: given segments replace the former ones of their
  // tracks, and a label that of the clip, but not segments of parts of it. Ends after a shorter
  // clip are removed, and segments after it. ABORTED if `before` was deleted or replaced since it
  // was listed; otherwise as AddClip.
  virtual absl::StatusOr<ClipRecord> ReplaceClip(const ClipRecord& before, const NewClip& clip) = 0;
  virtual absl::StatusOr<ClipRecord> GetClip(const std::string& database,
                                             const std::string& clip) = 0;
  virtual absl::StatusOr<std::vector<ClipRecord>> ListClips(const std::string& database,
                                                            const Page& page) = 0;
  // Deletes a clip and returns its record. The clip is invisible to other calls immediately. Its
  // states stay on disk for the current model and for a running build. PurgeDeletedClips, PutModel
  // and DropModel free them if the current model does not need them.
  virtual absl::StatusOr<ClipRecord> DeleteClip(const std::string& database,
                                                const std::string& clip,
                                                const WriteOptions& terms = {}) = 0;
  // Returns the ingested bytes.
  virtual absl::StatusOr<ClipSource> ReadClipSource(const std::string& database,
                                                    const std::string& clip) = 0;
  // Returns the unscaled states.
  virtual absl::StatusOr<core::StateSequence> ReadClipStates(const std::string& database,
                                                             const std::string& clip) = 0;

  // Stores the results of deriving clips of a database again, in one transaction. New states
  // replace the stored ones. The current model does not change: the old states stay on disk like
  // those of a deleted clip. Returns the records as stored. Skips clips that were deleted or
  // replaced since they were listed. Annotations and segments stay, as in ReplaceClip.
  // INVALID_ARGUMENT if a record's frame_count differs from the number of its states. ABORTED if
  // `fence` is outdated: see ModelTerms::fence.
  virtual absl::StatusOr<std::vector<ClipRecord>> PutDerived(const std::string& database,
                                                             std::span<const DerivedClip> clips,
                                                             std::int64_t fence = 0) = 0;

  // Skeletons, listed in order of id. Identical skeletons are stored once. The list skips corrupt
  // ones.
  virtual absl::StatusOr<core::Skeleton> GetSkeleton(const std::string& database,
                                                     const std::string& skeleton) = 0;
  virtual absl::StatusOr<std::vector<SkeletonRecord>> ListSkeletons(const std::string& database,
                                                                    const Page& page) = 0;

  // Models. The records of the last 1,000 models are kept. PutModel stores `model` as the current
  // model with the next version, frees data that only its predecessor needed, and returns the
  // record. It does not write the states: they are stored with the clips. A clip that was deleted
  // during the build stays in the model, so that frequent deletions do not block builds. NOT_FOUND
  // also if a clip of the model was never stored, or was deleted before the current model was
  // stored. `terms`: see ModelTerms.
  virtual absl::StatusOr<ModelRecord> PutModel(const std::string& database,
                                               const core::Model& model,
                                               const ModelTerms& terms = {}) = 0;
  // Stores an extension of the current model (core::ExtendModel) as the current model, with the
  // next version. It writes only the names of the added clips: ReadModel repeats the extension.
  // FAILED_PRECONDITION if `model` does not extend the current model; NOT_FOUND also if an added
  // clip is no longer stored.
  virtual absl::StatusOr<ModelRecord> PutExtension(const std::string& database,
                                                   const core::Model& model, double drift_fraction,
                                                   const ModelTerms& terms = {}) = 0;
  // Returns the current model, read on the threads of `parallel`. NOT_FOUND if there is none.
  virtual absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                                const core::ParallelFor& parallel) = 0;
  // Returns the current model, made from `base`, the model of a version, by reading only the clips
  // that were added to it. FAILED_PRECONDITION if the current model does not extend `base`.
  virtual absl::StatusOr<core::Model> ReadExtension(const std::string& database,
                                                    std::int32_t base_version,
                                                    const core::Model& base,
                                                    const core::ParallelFor& parallel) = 0;
  // Compares the current model with the stored clips. Without a model every clip is missing. A clip
  // that was replaced under the same id, or whose states were replaced, counts as removed and as
  // missing.
  virtual absl::StatusOr<ModelStaleness> FindModelStaleness(const std::string& database) = 0;
  virtual absl::StatusOr<ModelRecord> GetModel(const std::string& database, int version) = 0;
  // Returns at most `limit` models with a version below `before` (0: from the newest), newest
  // first.
  virtual absl::StatusOr<std::vector<ModelRecord>> ListModels(const std::string& database,
                                                              int before, int limit) = 0;
  // Removes the current model, for example after the last clip was deleted. OK if there is none.
  virtual absl::Status DropModel(const std::string& database, const ModelTerms& terms = {}) = 0;
  // Frees the states of deleted clips that the current model does not use. Do not call it during a
  // build: PutModel then returns NOT_FOUND for a model of a purged clip. DATA_LOSS if some states
  // cannot be read and stay; the rest is removed. CANCELLED if cancelled; the next call continues.
  virtual absl::Status PurgeDeletedClips(const std::string& database,
                                         const core::Cancelled& cancelled = {}) = 0;

  // Build leases: of the servers that share a store, one at a time builds the models of a database.
  // A lease ends when it is released, or `duration` after it was acquired or last renewed, by the
  // clock of the store.
  //
  // Returns the fencing number of the lease, which is higher than those of all earlier leases of
  // the database, and differs from those of other databases, also of a deleted one with its name. A
  // holder may acquire its own lease again. ABORTED, naming the holder, if another one has the
  // lease.
  virtual absl::StatusOr<std::int64_t> AcquireBuildLease(const std::string& database,
                                                         const std::string& holder,
                                                         std::chrono::milliseconds duration) = 0;
  // Renews also a lease that has expired, if there is no later one; otherwise ABORTED.
  virtual absl::Status RenewBuildLease(const std::string& database, std::int64_t fence,
                                       std::chrono::milliseconds duration) = 0;
  // OK also if it is no longer the last lease.
  virtual absl::Status ReleaseBuildLease(const std::string& database, std::int64_t fence) = 0;

  // The servers that share the store. A server is listed for `duration` after it was announced
  // last, by the clock of the store. Without effect, and empty, if the store is not shared.
  virtual absl::Status AnnounceServer(const ServerAddress& server,
                                      std::chrono::milliseconds duration);
  virtual absl::StatusOr<std::vector<ServerAddress>> ListServers();

  // Operations. PutOperation creates or replaces an operation of an existing database. Operations
  // are deleted with their database. The last 1,000 finished operations of a database are kept.
  // CANCELLED, with nothing changed, if cancelled before the write began. ABORTED if the operation
  // has ended: its result never changes. NOT_FOUND if it is an operation of a deleted database
  // whose data is not freed yet, also if there is a new database with the name. ABORTED also if the
  // database is not the one with `record.database_id`.
  virtual absl::Status PutOperation(const OperationRecord& record,
                                    const core::Cancelled& cancelled = {}) = 0;
  virtual absl::StatusOr<OperationRecord> GetOperation(const std::string& operation) = 0;
  // Returns at most `limit` operations in reverse order of creation, of one database or of all
  // (`database` empty). `before` is the id of the last operation of the previous page, or empty.
  virtual absl::StatusOr<std::vector<OperationRecord>> ListOperations(const std::string& database,
                                                                      const std::string& before,
                                                                      int limit) = 0;
  // Returns the operations of all databases that have not ended, in order of creation.
  virtual absl::StatusOr<std::vector<OperationRecord>> ListUnfinishedOperations() = 0;

  // Returns OK if the store accepts additions. RESOURCE_EXHAUSTED (out of disk space), UNAVAILABLE
  // (missing file or disk error), or the error of a write. If the last write failed or disk space
  // is low, it blocks for a small test write, at most once a second.
  virtual absl::Status CheckWrites() = 0;
  virtual WriteFailures write_failures() const = 0;
  virtual ConnectionStatistics connections() const { return {}; }

  // Calls `on_change` after changes of this or another server, from another thread, until the
  // result is destroyed. Null if the store is never changed by another server, or cannot notify.
  // Calls can be lost and repeated: whoever must not miss a change also polls Revision.
  // NOLINTNEXTLINE(performance-unnecessary-value-param): other stores move it.
  virtual std::unique_ptr<StoreWatch> WatchChanges(OnStoreChange) { return nullptr; }

  // Edits, segments, changes and text search. Valid as long as this store.
  virtual AnnotationStore& annotations() = 0;

  // Tokens and the audit log. Valid as long as this store.
  virtual AccessStore& access() = 0;

  // Verify, backup and restore. Valid as long as this store.
  virtual StoreMaintenance& maintenance() = 0;
};

}  // namespace motiondb::storage
