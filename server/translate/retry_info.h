// Errors that say when to try again. The time travels in the absl::Status as a payload, a RetryInfo
// under google.rpc's type URL, and reaches the client with it. Safe to call from any thread.
#pragma once

#include <chrono>

#include "absl/status/status.h"

namespace motiondb::server {

// The same status, which must not be OK, with how long to wait.
absl::Status RetryAfter(absl::Status status, std::chrono::milliseconds delay);

}  // namespace motiondb::server
