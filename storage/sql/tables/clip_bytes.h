// The column `byte_count` of the table `clip`: the size of the clip's blobs.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Sets byte_count and the row checksum of a clip from its stored blobs, in the caller's
// transaction.
absl::Status UpdateByteCount(Connection& connection, std::int64_t clip_key);

// Sets byte_count of all clips of older versions, which did not store it: 1,000 clips per
// transaction. If a chunk cannot be read, byte_count is 0. Other errors are ignored, so that the
// store can be opened: those clips are counted at the next opening.
void FillMissingByteCounts(Connection& connection);

}  // namespace motiondb::storage
