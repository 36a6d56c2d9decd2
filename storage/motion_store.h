// Where databases, clips, models and operations are kept. The seam between the server and a disk:
// one conformance suite (tests/storage) runs on every implementation.
//
// Implementations are safe to call from any thread. A call that changes something returns only when
// the change is durable, and changes all or nothing. Names are checked by the caller; a store
// accepts any non-empty string. Codes used by all: NOT_FOUND (what was named is not there),
// ALREADY_EXISTS, DATA_LOSS (stored bytes are damaged: names which), UNAVAILABLE or
// RESOURCE_EXHAUSTED (disk).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/tree/parallel.h"
#include "storage/access_store.h"
#include "storage/records.h"
#include "storage/store_upkeep.h"

namespace motiondb::core {
class Model;
}

namespace motiondb::storage {

// One page of a list, in ascending order of a key: those after `after` (empty: from the start), at
// most `limit` (positive).
struct Page {
  std::string after;
  int limit = 100;
};

// Writes that failed since the store was opened, by cause.
struct WriteFailures {
  std::int64_t no_space = 0;    // no room on the disk, or no memory
  std::int64_t io_error = 0;    // the disk, or the file is gone or read-only
  std::int64_t corruption = 0;  // what is stored cannot be read
  std::int64_t other = 0;

  std::int64_t total() const { return no_space + io_error + corruption + other; }
};

class MotionStore {
 public:
  virtual ~MotionStore() = default;

  // Databases, in order of name.
  virtual absl::Status CreateDatabase(const DatabaseRecord& record,
                                      const ChangeTerms& terms = {}) = 0;
  virtual absl::StatusOr<DatabaseRecord> GetDatabase(const std::string& database) = 0;
  virtual absl::StatusOr<std::vector<DatabaseRecord>> ListDatabases(const Page& page) = 0;
  // With all that it holds: it is gone for every other call at once, and its name is free. What it
  // held stays on disk until PurgeDeletedDatabases.
  virtual absl::Status DeleteDatabase(const std::string& database,
                                      const ChangeTerms& terms = {}) = 0;
  // Removes what is left of deleted databases, in many short changes, between which others get
  // their turn. It may be called beside all else, one call at a time. CANCELLED, with the rest left
  // for the next call, once `cancelled` says so. DATA_LOSS if something cannot be read and stays;
  // all else is removed.
  virtual absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) = 0;

  // Clips, in order of id. AddClip returns the record as stored: where the wanted id is taken by
  // another file, "-2", "-3", ... is added, unless id_is_fixed. ALREADY_EXISTS, naming the clip, if
  // the same content is stored already or a fixed id is taken. INVALID_ARGUMENT if the record does
  // not tell the frames of the states. FAILED_PRECONDITION if the clip brings a marker set and the
  // database has another.
  virtual absl::StatusOr<ClipRecord> AddClip(const NewClip& clip) = 0;
  virtual absl::StatusOr<ClipRecord> GetClip(const std::string& database,
                                             const std::string& clip) = 0;
  virtual absl::StatusOr<std::vector<ClipRecord>> ListClips(const std::string& database,
                                                            const Page& page) = 0;
  // The clip is gone for every other call at once. Its states stay on disk, for the current model
  // and for one that is being built from them, until PurgeDeletedClips, or a model that is put or
  // dropped, finds that the current model does not need them. Returns the record of what was
  // deleted.
  virtual absl::StatusOr<ClipRecord> DeleteClip(const std::string& database,
                                                const std::string& clip,
                                                const ChangeTerms& terms = {}) = 0;
  // The bytes that were ingested.
  virtual absl::StatusOr<ClipSource> ReadClipSource(const std::string& database,
                                                    const std::string& clip) = 0;
  // Not scaled.
  virtual absl::StatusOr<core::StateSequence> ReadClipStates(const std::string& database,
                                                             const std::string& clip) = 0;

  // Stores what deriving clips of a database again came to, all in one change. States that it
  // brings replace those stored, which stay on disk beside them as those of a deleted clip do: the
  // current model is not changed by it. Returns the records as stored; clips that were deleted, or
  // replaced by others, since they were listed are passed over. INVALID_ARGUMENT if a record does
  // not tell the frames of its states.
  virtual absl::StatusOr<std::vector<ClipRecord>> PutDerived(
      const std::string& database, std::span<const DerivedClip> clips) = 0;

  // Skeletons, in order of id; alike ones are stored once. The list passes over damaged ones.
  virtual absl::StatusOr<core::Skeleton> GetSkeleton(const std::string& database,
                                                     const std::string& skeleton) = 0;
  virtual absl::StatusOr<std::vector<SkeletonRecord>> ListSkeletons(const std::string& database,
                                                                    const Page& page) = 0;

  // Models; the figures of the last thousand are kept. PutModel stores a model as the current one,
  // under the version after the last, removes what only its predecessor needed, and returns its
  // record. The model's states are not written again: they are those of its clips. A clip that was
  // deleted while the model was built stays in it, as in a current one, so that models are put
  // however often clips are deleted. NOT_FOUND also if one of its clips was never stored, or
  // deleted before the model that is current.
  virtual absl::StatusOr<ModelRecord> PutModel(const std::string& database,
                                               const core::Model& model) = 0;
  // Stores a model that extends the current one by clips (core::ExtendModel) as the current one,
  // under the next version. Only the names of its added clips are written: ReadModel extends the
  // built model by them again. FAILED_PRECONDITION if it does not extend the current model;
  // NOT_FOUND also if one of the added clips is not stored by now.
  virtual absl::StatusOr<ModelRecord> PutExtension(const std::string& database,
                                                   const core::Model& model,
                                                   double drift_fraction) = 0;
  // The current model, whole, read on the threads that the caller lends. NOT_FOUND if there is
  // none.
  virtual absl::StatusOr<core::Model> ReadModel(const std::string& database,
                                                const core::ParallelFor& parallel) = 0;
  // Between the current model and the clips; without a model every clip is missing. A clip that was
  // replaced by another of the same id, or that has other states by now, counts on both sides.
  virtual absl::StatusOr<ModelStaleness> FindModelStaleness(const std::string& database) = 0;
  virtual absl::StatusOr<ModelRecord> GetModel(const std::string& database, int version) = 0;
  // Newest first. `before` = 0 starts with the newest.
  virtual absl::StatusOr<std::vector<ModelRecord>> ListModels(const std::string& database,
                                                              int before, int limit) = 0;
  // Leaves the database without a current model (its last clip was deleted). OK if there is none.
  virtual absl::Status DropModel(const std::string& database) = 0;
  // Removes what is left of deleted clips, but of those that the current model knows. A model that
  // is being built from one of the others cannot be put afterwards (NOT_FOUND): not to be called
  // during a build. DATA_LOSS if what is left of one cannot be read and stays; the others are
  // removed. CANCELLED, with nothing removed.
  virtual absl::Status PurgeDeletedClips(const std::string& database,
                                         const core::Cancelled& cancelled = {}) = 0;

  // Operations. PutOperation creates or replaces one of a database that there is. Operations are
  // deleted with their database; of those that ended, the last thousand of a database are kept.
  // CANCELLED, with nothing changed, where it was cancelled before its turn to be written.
  virtual absl::Status PutOperation(const OperationRecord& record,
                                    const core::Cancelled& cancelled = {}) = 0;
  virtual absl::StatusOr<OperationRecord> GetOperation(const std::string& operation) = 0;
  // Newest first, by when they were created; of one database, or of all where `database` is empty.
  // `before` is the id of the last one of the page before, or empty.
  virtual absl::StatusOr<std::vector<OperationRecord>> ListOperations(const std::string& database,
                                                                      const std::string& before,
                                                                      int limit) = 0;

  // OK if additions are accepted. RESOURCE_EXHAUSTED (the disk lacks room), UNAVAILABLE (the file
  // is gone, or the disk fails), or what a write failed with. Once a second at most it tries a
  // small write, if the last write failed or the disk lacks room; it takes as long as that.
  virtual absl::Status CheckWrites() = 0;
  virtual WriteFailures write_failures() const = 0;

  // Tokens and the record of changes, kept with the motion; as long-lived as this store.
  virtual AccessStore& access() = 0;

  // Checking, copying and filling the store as a whole; as long-lived as this store.
  virtual StoreUpkeep& upkeep() = 0;
};

}  // namespace motiondb::storage
