// Rows of the table `clip` and the blobs of clips. Functions keep no state; they run in the
// transaction of their caller. Where a database or clip is named, NOT_FOUND says that it is not
// there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "storage/motion_store.h"
#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// As MotionStore::AddClip. INVALID_ARGUMENT if the record does not tell the frames of the states.
absl::StatusOr<ClipRecord> InsertClip(Connection& connection, const NewClip& clip);
// As MotionStore::PutDerived.
absl::StatusOr<std::vector<ClipRecord>> PutDerivedClips(Connection& connection,
                                                        const std::string& database,
                                                        std::span<const DerivedClip> clips);
absl::StatusOr<ClipRecord> SelectClip(Connection& connection, const std::string& database,
                                      const std::string& clip);
absl::StatusOr<std::vector<ClipRecord>> SelectClips(Connection& connection,
                                                    const std::string& database, const Page& page);
absl::StatusOr<ClipSource> SelectClipSource(Connection& connection, const std::string& database,
                                            const std::string& clip);
absl::StatusOr<core::StateSequence> SelectClipStates(Connection& connection,
                                                     const std::string& database,
                                                     const std::string& clip);

// What becomes of bytes that nothing needs any more. Freeing them takes reading where they are, so
// a sector that cannot be read keeps them: DATA_LOSS, which undoes the whole transaction. A change
// that is to happen all the same leaves them.
enum class Remains { kFree, kLeave };

// Deletes a clip and returns its record. Its states stay, for the current model and for one that is
// being built.
absl::StatusOr<ClipRecord> RemoveClip(Connection& connection, const std::string& database,
                                      const std::string& clip, Remains remains);
// Deletes what is left of those of the clips that are deleted and that no model needs.
absl::Status PurgeRemovedClips(Connection& connection, std::span<const std::int64_t> clip_keys);
// The keys of all such clips, ascending.
absl::StatusOr<std::vector<std::int64_t>> SelectRemovedClips(Connection& connection,
                                                             const std::string& database);

// Whether a clip counts of which only what RemoveClip leaves is there.
enum class Deleted { kNot, kToo };
// The clip that a model was built from. NOT_FOUND also if another is stored under its id.
// `root_path` is the model's for the clip's frames: frames x 3, row-major.
absl::StatusOr<std::int64_t> FindModelClip(Connection& connection, std::int64_t database_key,
                                           const core::ModelClip& clip,
                                           std::span<const double> root_path, Deleted deleted);

inline BlobOwner ClipOwner(std::int64_t clip_key) { return {"clip", clip_key}; }

}  // namespace motiondb::storage
