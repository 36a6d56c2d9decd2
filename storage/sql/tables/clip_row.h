// Rows of the table `clip` as records. The functions run in the caller's transaction. NOT_FOUND if
// a named database or clip does not exist.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Keys and names of a clip.
struct ClipRef {
  std::int64_t database_key = 0;
  std::int64_t clip_key = 0;
  std::string database;
  std::string clip;
};
absl::StatusOr<ClipRef> FindClip(Connection& connection, const std::string& database,
                                 const std::string& clip);

absl::StatusOr<ClipRecord> SelectClip(Connection& connection, const std::string& database,
                                      const std::string& clip);
absl::StatusOr<std::vector<ClipRecord>> SelectClips(Connection& connection,
                                                    const std::string& database, const Page& page);
// Returns the clips with a revision above `after` up to `last`, in order of revision and id.
absl::StatusOr<std::vector<ClipRecord>> SelectChangedClips(Connection& connection,
                                                           std::int64_t database_key,
                                                           const std::string& database,
                                                           std::int64_t after, std::int64_t last);

// Inserts a row without byte_count and row_crc, which UpdateByteCount sets, and returns its key.
// `skeleton_key` 0: no skeleton.
absl::StatusOr<std::int64_t> InsertClipRow(Connection& connection, std::int64_t database_key,
                                           std::int64_t skeleton_key, const ClipRecord& record,
                                           const core::RootPath& path);
// Updates the values that an attempt to derive the clip again changes, and the revision.
absl::Status UpdateDerivation(Connection& connection, std::int64_t clip_key,
                              const ClipRecord& record);
// Updates the values that an edit changes, and the revision.
absl::Status UpdateAnnotations(Connection& connection, std::int64_t clip_key,
                               const ClipRecord& record);

std::string DescribeClip(const std::string& database, const std::string& clip);
absl::Status NoClip(const std::string& database, const std::string& clip);

// Sets byte_count, the size of the clip's blobs, and the row checksum of a clip from its stored
// blobs.
absl::Status UpdateByteCount(Connection& connection, std::int64_t clip_key);

// Sets byte_count of all clips of older versions, which did not store it, in its own transactions
// of 1,000 clips. If a chunk cannot be read, byte_count is 0. Other errors are ignored, so that the
// store can be opened: those clips are counted at the next opening.
void FillMissingByteCounts(Connection& connection);

}  // namespace motiondb::storage
