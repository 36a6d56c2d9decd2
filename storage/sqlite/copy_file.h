// Temporary files beside the store, of backup, restore, export and import, and copying a store
// between connections.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/sql/connection.h"

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

// Deletes temporary files of a killed process. REQUIRES: the caller holds the StoreLock.
void DeleteStaleCopies(const std::string& store_path);

// Copies all pages from a consistent view of `from` to `to`; after an error `to` is unchanged.
// REQUIRES: `from` is in a transaction that has read, or has no other writer; `to` is in no
// transaction. CANCELLED, or the codes of SqliteError.
absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled);

}  // namespace motiondb::storage
