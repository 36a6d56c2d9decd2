// A store file in a temporary folder, which the destructor deletes, and raw SQL on the file.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <memory>
#include <string>

#include "storage/sqlite/sqlite_motion_store.h"
#include "tests/storage/faults/corrupt_store.h"
#include "tests/storage/require_ok.h"

namespace motiondb::tests {

class StoreFile {
 public:
  StoreFile() {
    std::string pattern = (std::filesystem::temp_directory_path() / "motiondb-XXXXXX").string();
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    folder_ = pattern;
  }
  StoreFile(const StoreFile&) = delete;
  StoreFile& operator=(const StoreFile&) = delete;
  ~StoreFile() { std::filesystem::remove_all(folder_); }

  std::string path() const { return (folder_ / "store.db").string(); }
  const std::filesystem::path& folder() const { return folder_; }

  absl::StatusOr<std::unique_ptr<storage::SqliteMotionStore>> TryOpen(
      storage::SqliteOptions options = {}) const {
    return storage::SqliteMotionStore::Open(path(), std::move(options));
  }
  // Returns the names of the files in the folder that do not belong to the store, each with a
  // space.
  std::string OtherFiles() const {
    std::string names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name == "store.db" || name == "store.db-wal" || name == "store.db-shm") continue;
      if (name != "store.db-lock") names += name + " ";
    }
    return names;
  }

  std::unique_ptr<storage::SqliteMotionStore> Open(storage::SqliteOptions options = {}) const {
    return Require(TryOpen(std::move(options)));
  }

  // See RunSql.
  std::string Sql(const std::string& script) const { return RunSql(path(), script); }

 private:
  std::filesystem::path folder_;
};

}  // namespace motiondb::tests
