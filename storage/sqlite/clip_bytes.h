// What the blobs of a clip take, with the clip. Functions keep no state.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// Counts it for a clip whose blobs are there, and sets the checksum of the clip's row, in the
// transaction of the caller.
absl::Status CountBytes(Connection& connection, std::int64_t clip_key);

// Counts it for all clips of versions that did not: in transactions of its own, a thousand clips in
// each. A clip with a chunk that cannot be read counts as 0. What fails otherwise is left to the
// next opening, and counts as 0 meanwhile: it is no reason not to open a store.
void CountUncountedBytes(Connection& connection);

}  // namespace motiondb::storage
