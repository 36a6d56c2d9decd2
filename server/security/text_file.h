// Reads a small file that an operator named. Safe to call from any thread.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

// INVALID_ARGUMENT, naming the file and why it cannot be read.
absl::StatusOr<std::string> ReadTextFile(const std::string& path);

}  // namespace motiondb::server
