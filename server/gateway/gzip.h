// Compression of requests and responses (RFC 1952).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Returns the decompressed bytes. Calls `admit` with the total before it allocates more, at most
// doubling it each time, and returns its error. INVALID_ARGUMENT if the data is not exactly one
// complete gzip member.
absl::StatusOr<std::string> Gunzip(std::string_view bytes,
                                   const std::function<absl::Status(std::int64_t)>& admit);

// Returns the bytes compressed at the fastest level. Throws std::bad_alloc.
std::string Gzip(std::string_view bytes);

}  // namespace motiondb::server
