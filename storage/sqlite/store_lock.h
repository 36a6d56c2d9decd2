// The right to write to a store, held by one object in one process at a time: two writers could
// damage the file (SQLite before 3.51.3 may when two connections write or checkpoint at once).
//
// It is an flock on a file beside the store, "<store>-lock", which the system lets go when the
// process ends, however it ends. The file stays; it means nothing by itself.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::storage {

class StoreLock {
 public:
  // FAILED_PRECONDITION, naming the process, if another holds it; UNAVAILABLE if the lock file
  // cannot be made.
  static absl::StatusOr<StoreLock> Acquire(const std::string& store_path);
  StoreLock(StoreLock&& other) noexcept;
  StoreLock& operator=(StoreLock&& other) noexcept;
  ~StoreLock();

 private:
  explicit StoreLock(int file) : file_(file) {}

  int file_;  // descriptor; -1 once moved from
};

}  // namespace motiondb::storage
