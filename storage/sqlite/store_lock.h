// The right to write to a store, held by one object in one process at a time: two writers could
// damage the file (SQLite before 3.51.3 may when two connections write or checkpoint at once).
//
// It is an flock on a file beside the store, "<store>-lock", which the system lets go when the
// process ends, however it ends. The file stays; it means nothing by itself.
//
// So the lock goes by the store's name, as SQLite's log does, and a store that has several names
// (hard links) is refused. A lock on the store's own inode would keep a second server out, but not
// the harm: by its other name a store is opened without the log of the first, which after a kill
// holds what was acknowledged. Nor could it be had safely on every file system: where flock is made
// of fcntl locks, as on NFS, it would clash with those that SQLite takes on the same file.
#pragma once

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::storage {

class StoreLock {
 public:
  // Any number may hold kShared together; who holds kAlone holds it alone.
  enum class Kind { kAlone, kShared };

  // The store need not be there. FAILED_PRECONDITION, naming the process, if another holds it, or,
  // putting nothing beside it, if the store has several names; UNAVAILABLE if the lock file cannot
  // be made.
  // kShared changes nothing: where the lock file is not there and cannot be made, on a read-only
  // file system, nobody can write, and the lock is held without a file.
  static absl::StatusOr<StoreLock> Acquire(const std::string& store_path, Kind kind = Kind::kAlone);
  StoreLock(StoreLock&& other) noexcept;
  StoreLock& operator=(StoreLock&& other) noexcept;
  ~StoreLock();

 private:
  explicit StoreLock(int file) : file_(file) {}

  int file_;  // descriptor; -1: none, or moved from
};

}  // namespace motiondb::storage
