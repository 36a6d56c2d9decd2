// The disk of a store: the space that must stay free, and temporary files beside the store.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// The disk space that additions to a store must leave free. A deletion first needs space in the
// log; without the reserve, a store that fills its disk could not be emptied.
class DiskReserve {
 public:
  // Reserves `bytes` on the disk of the store at `path`; 0: no check.
  DiskReserve(std::string path, std::int64_t bytes) : path_(std::move(path)), bytes_(bytes) {}

  bool is_off() const { return bytes_ == 0; }
  // RESOURCE_EXHAUSTED, with the free and the required bytes, if the disk has no room for
  // `added_bytes` in the log and in the file, in addition to the present log and the reserve.
  // Empties the log if that may free space. REQUIRES: runs on the writer thread; `writer` is in no
  // transaction.
  absl::Status Check(Connection& writer, std::int64_t added_bytes) const;

  // Returns whether the disk has more free space than the reserve; if not, every addition fails.
  // True if the free space is unknown. Any thread may call it.
  bool HasReserve() const;
  // RESOURCE_EXHAUSTED if there is no room for `added_bytes` of a file beside the store.
  absl::Status CheckTemporaryFile(std::int64_t added_bytes) const;

  // Empties the log if less space is free than the reserve, to return the space that earlier
  // deletions used in the log. REQUIRES: as Check.
  void GiveBack(Connection& writer) const;

 private:
  struct Room {
    std::int64_t free = 0;   // free bytes of the disk
    std::int64_t log = 0;    // size of the log, bytes
    std::int64_t freed = 0;  // unused bytes in the file; additions use these first
  };
  absl::StatusOr<std::int64_t> FreeBytes() const;
  absl::StatusOr<Room> Look(Connection& writer) const;
  absl::Status Refuse(std::int64_t free, std::int64_t added_bytes) const;
  std::int64_t Needed(const Room& room, std::int64_t added_bytes) const;

  const std::string path_;
  const std::int64_t bytes_;
};

// Temporary files beside the store, of backup, restore, export and import. A store without a file
// has a folder for them.

// A unique hidden file name beside the store. The destructor deletes the file.
class CopyFile {
 public:
  // `purpose` is "backup", "restore", "export" or "import".
  CopyFile(const std::string& store_path, const std::string& purpose);
  CopyFile(const CopyFile&) = delete;
  CopyFile& operator=(const CopyFile&) = delete;
  ~CopyFile() { Remove(); }

  const std::string& path() const { return path_; }
  void Remove();

 private:
  const std::string path_;
};

// A new folder among the temporary files (TMPDIR), which only this user can read. The destructor
// deletes it with its files; they stay if the process is killed. Thread-safe.
class CopyFolder {
 public:
  CopyFolder() = default;
  CopyFolder(const CopyFolder&) = delete;
  CopyFolder& operator=(const CopyFolder&) = delete;
  ~CopyFolder();

  // Returns a store path in the folder for CopyFile; creates the folder. UNAVAILABLE if it cannot.
  absl::StatusOr<std::string> StorePath();

 private:
  Mutex mutex_;
  std::string path_ ABSL_GUARDED_BY(mutex_);  // empty: not created
};

// Deletes temporary files of a killed process. REQUIRES: the caller holds the StoreLock.
void DeleteStaleCopies(const std::string& store_path);

}  // namespace motiondb::storage
