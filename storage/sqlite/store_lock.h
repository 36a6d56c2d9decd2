// Lock of a store, and the identity of its files. Only one object in one process may write to a
// store: two writers could corrupt the file (SQLite before 3.51.3 may do so if two connections
// write or checkpoint at the same time).
//
// The lock is an flock on the file "<store>-lock" beside the store. The system releases it when the
// process ends in any way. The file stays; alone it has no meaning.
//
// The lock depends on the store's name, like SQLite's log. Therefore a store with several names
// (hard links) is refused: opened by another name, it would lack the log, which after a kill
// contains acknowledged changes. A lock on the store's inode would not prevent that. It would also
// conflict with SQLite's own locks on file systems that implement flock with fcntl locks, such as
// NFS.
#pragma once

#include <sys/types.h>

#include <string>

#include "absl/status/statusor.h"

namespace motiondb::storage {

class StoreLock {
 public:
  // kShared: any number of holders. kExclusive: exclusive.
  enum class Kind { kExclusive, kShared };

  // The store need not exist. FAILED_PRECONDITION, naming the process, if the lock is held;
  // FAILED_PRECONDITION, without creating a file, if the store has several names; UNAVAILABLE if
  // the lock file cannot be created. With kShared, a missing lock file that cannot be created is no
  // error: on a read-only file system there is no writer.
  static absl::StatusOr<StoreLock> Acquire(const std::string& store_path,
                                           Kind kind = Kind::kExclusive);
  StoreLock(StoreLock&& other) noexcept;
  StoreLock& operator=(StoreLock&& other) noexcept;
  ~StoreLock();

 private:
  explicit StoreLock(int file) : file_(file) {}

  int file_;  // descriptor; -1: none, or moved from
};

// Shows that a file was replaced by another file of the same name.
struct FileIdentity {
  dev_t device = 0;
  ino_t inode = 0;
};

// Returns the identity of the file at `path`. UNAVAILABLE if there is none.
absl::StatusOr<FileIdentity> GetFileIdentity(const std::string& path);

// UNAVAILABLE if the file at `path` is missing or is not `file`.
absl::Status CheckFileIdentity(const std::string& path, const FileIdentity& file);

}  // namespace motiondb::storage
