// Files beside a store that live as long as a backup or a restore, and copying a store from one
// connection to another. Functions keep no state.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// A hidden name beside the store that no other has, and the promise that nothing stays there.
class CopyFile {
 public:
  // `purpose` is "backup" or "restore".
  CopyFile(const std::string& store_path, const std::string& purpose);
  CopyFile(const CopyFile&) = delete;
  CopyFile& operator=(const CopyFile&) = delete;
  ~CopyFile() { Remove(); }

  const std::string& path() const { return path_; }
  void Remove();

 private:
  const std::string path_;
};

// Deletes what a process that was killed left. REQUIRES: the lock of the store is held.
void RemoveLeftCopies(const std::string& store_path);

// Copies all pages, as `from` sees them at one moment. REQUIRES: `from` is in a transaction in
// which it has read, or has no other writer; `to` is in none. CANCELLED; else the codes of SQLite.
// `to` then holds all or, after an error, nothing of it.
absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled);

}  // namespace motiondb::storage
