// Tells a file from another that took its name. Functions keep no state.
#pragma once

#include <sys/types.h>

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::storage {

struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
};

// Of the file that `path` leads to. UNAVAILABLE: "'PATH' is gone (why)".
absl::StatusOr<FileIdentity> IdentityOf(const std::string& path);

// OK while `path` leads to that file. UNAVAILABLE: as above, or "'PATH' is not the file that it
// was".
absl::Status CheckIsFile(const std::string& path, const FileIdentity& file);

}  // namespace motiondb::storage
