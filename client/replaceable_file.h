// Whether a file may be replaced by another of its name. Safe to call from any thread.
#pragma once

#include <filesystem>

#include "absl/status/status.h"

namespace motiondb::client {

// OK where there is nothing, or a regular file that is no server's store: a backup may be replaced,
// unless a server has it as its store. Else FAILED_PRECONDITION, naming the path and what it is. A
// file that cannot be read might be a store, and is not replaced either.
absl::Status CheckReplaceable(const std::filesystem::path& path);

}  // namespace motiondb::client
