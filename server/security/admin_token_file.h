// The file that holds an administrator's token, for those who set servers up by programs. Safe to
// call from any thread.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::server {

// The token, without the white space around it. INVALID_ARGUMENT, naming the file and nothing of
// what it holds: it cannot be read, everybody can read it, others than its owner can write
// it, or its token is shorter than 20 characters or has others than printable ASCII ones.
absl::StatusOr<std::string> ReadAdminToken(const std::string& path);

}  // namespace motiondb::server
