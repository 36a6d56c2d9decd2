// Rows of the table `clip` and the blobs of clips. The functions run in the caller's transaction.
// NOT_FOUND if a named database or clip does not exist.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/states.h"
#include "storage/motion_store.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/clip_row.h"

namespace motiondb::storage {

// See MotionStore::AddClip.
absl::StatusOr<ClipRecord> InsertClip(Connection& connection, const NewClip& clip);
// See MotionStore::FindSameClip.
absl::StatusOr<ClipRecord> SelectSameClip(Connection& connection, const NewClip& clip);
// See MotionStore::PutDerived.
absl::StatusOr<std::vector<ClipRecord>> PutDerivedClips(Connection& connection,
                                                        const std::string& database,
                                                        std::span<const DerivedClip> clips,
                                                        std::int64_t fence);
absl::StatusOr<ClipSource> SelectClipSource(Connection& connection, const std::string& database,
                                            const std::string& clip);
absl::StatusOr<core::StateSequence> SelectClipStates(Connection& connection,
                                                     const std::string& database,
                                                     const std::string& clip);

// Whether a deletion frees bytes that are no longer needed. To free bytes, SQLite must read their
// pages; an unreadable sector causes DATA_LOSS and a rollback. kLeave avoids that.
enum class FreePolicy { kFree, kLeave };

// Deletes a clip and returns its record. Its states stay for the current model and a running build.
absl::StatusOr<ClipRecord> RemoveClip(Connection& connection, const std::string& database,
                                      const std::string& clip, FreePolicy remains);
// See MotionStore::ReplaceClip.
absl::StatusOr<ClipRecord> ReplaceClip(Connection& connection, const ClipRecord& before,
                                       const NewClip& clip, FreePolicy remains);
// Deletes the rows and states of those clips in `clip_keys` that are deleted and used by no model.
absl::Status PurgeRemovedClips(Connection& connection, std::span<const std::int64_t> clip_keys);
// Returns the keys of all clips that PurgeRemovedClips would delete, ascending.
absl::StatusOr<std::vector<std::int64_t>> SelectRemovedClips(Connection& connection,
                                                             const std::string& database);

inline BlobOwner ClipOwner(std::int64_t clip_key) { return {"clip", clip_key}; }

}  // namespace motiondb::storage
