// Temporary files beside the store, of backup, restore, export and import, and copying a store
// between connections. A store without a file has a folder for them.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "storage/mutex.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

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

// Copies all pages from a consistent view of `from` to `to`; after an error `to` is unchanged.
// REQUIRES: `from` is in a transaction that has read, or has no other writer; `to` is in no
// transaction. CANCELLED, or the codes of SqliteError.
absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled);

}  // namespace motiondb::storage
