// Compares all rows of two stores of any engines, bit by bit.
#pragma once

#include <cstdint>
#include <functional>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Compares every column of every row, the search texts included, and the checksums of the rows of
// `copy`. DATA_LOSS names the first row that differs. `on_bytes` gets the bytes of blobs compared
// so far. In the caller's read transactions. CANCELLED.
absl::Status CompareStores(Connection& source, Connection& copy,
                           const std::function<void(std::int64_t bytes)>& on_bytes,
                           const core::Cancelled& cancelled);

}  // namespace motiondb::storage
