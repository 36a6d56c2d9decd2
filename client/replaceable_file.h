// Whether a file may be replaced by another of its name. Safe to call from any thread.
#pragma once

#include <filesystem>

#include "absl/status/status.h"

namespace motiondb::client {

// OK where there is nothing, or an empty file, or a backup that no server has as its store. Else
// FAILED_PRECONDITION, naming the path and what it is. What cannot be read is not replaced either.
absl::Status CheckReplaceable(const std::filesystem::path& path);

}  // namespace motiondb::client
