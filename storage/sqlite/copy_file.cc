#include "storage/sqlite/copy_file.h"

#include <fmt/format.h>

#include <atomic>
#include <filesystem>
#include <vector>

#include "storage/sqlite/sqlite_status.h"

namespace motiondb::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kPagesAtOnce = 256;

// A hidden name, which nobody gives a copy of their own.
std::string Prefix(const fs::path& store) { return fmt::format(".{}.", store.filename().string()); }

}  // namespace

CopyFile::CopyFile(const std::string& store_path, const std::string& purpose)
    : path_([&] {
        static std::atomic<int> number = 0;
        const fs::path store(store_path);
        return (store.parent_path() / fmt::format("{}{}-{}", Prefix(store), purpose, ++number))
            .string();
      }()) {
  Remove();
}

void CopyFile::Remove() {
  std::error_code ignored;
  for (const char* const suffix : {"", "-wal", "-shm", "-journal"}) {
    fs::remove(path_ + suffix, ignored);
  }
}

void RemoveLeftCopies(const std::string& store_path) {
  const fs::path path(store_path);
  std::error_code ignored;
  std::vector<fs::path> left;
  for (const fs::directory_entry& entry : fs::directory_iterator(path.parent_path(), ignored)) {
    if (entry.path().filename().string().starts_with(Prefix(path))) left.push_back(entry.path());
  }
  for (const fs::path& file : left) fs::remove(file, ignored);
}

absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled) {
  sqlite3_backup* const copy = sqlite3_backup_init(to.handle(), "main", from.handle(), "main");
  if (copy == nullptr) return SqliteError(to.handle(), sqlite3_extended_errcode(to.handle()));
  int code = SQLITE_OK;
  bool stopped = false;
  while (code == SQLITE_OK && !stopped) {
    stopped = cancelled && cancelled();
    if (!stopped) code = sqlite3_backup_step(copy, kPagesAtOnce);
  }
  // Undoes what was written, unless the last step was the end.
  const int finished = sqlite3_backup_finish(copy);
  if (stopped) return absl::CancelledError("stopped");
  if (code == SQLITE_DONE) code = finished;
  if (code != SQLITE_OK) return SqliteError(to.handle(), code);
  return absl::OkStatus();
}

}  // namespace motiondb::storage
