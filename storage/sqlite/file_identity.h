// Detects that a file was replaced by another file of the same name.
#pragma once

#include <sys/types.h>

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::storage {

struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
};

// Returns the identity of the file at `path`. UNAVAILABLE if there is none.
absl::StatusOr<FileIdentity> GetFileIdentity(const std::string& path);

// UNAVAILABLE if the file at `path` is missing or is not `file`.
absl::Status CheckFileIdentity(const std::string& path, const FileIdentity& file);

}  // namespace motiondb::storage
