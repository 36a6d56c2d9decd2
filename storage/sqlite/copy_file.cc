#include "storage/sqlite/copy_file.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/sqlite_statement.h"

namespace motiondb::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kPagesAtOnce = 256;

// Returns the prefix of the names of temporary files: hidden, to avoid names that users choose.
std::string Prefix(const fs::path& store) { return fmt::format(".{}.", store.filename().string()); }

// Suffixes of the files that SQLite writes for a database.
constexpr std::array<std::string_view, 4> kSuffixes = {"", "-wal", "-shm", "-journal"};

// Returns whether `name` is a temporary file of `store` or a file that SQLite wrote beside one. The
// whole name must match: another store in the folder may have a name that begins alike.
bool IsOfCopy(std::string_view name, const fs::path& store) {
  const std::string prefix = Prefix(store);
  if (!name.starts_with(prefix)) return false;
  name.remove_prefix(prefix.size());
  for (const std::string_view purpose : {"backup-", "restore-", "export-", "import-"}) {
    if (!name.starts_with(purpose)) continue;
    name.remove_prefix(purpose.size());
    const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
    return digits > 0 && std::ranges::count(kSuffixes, name.substr(digits)) > 0;
  }
  return false;
}

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
  for (const std::string_view suffix : kSuffixes)
    fs::remove(fmt::format("{}{}", path_, suffix), ignored);
}

CopyFolder::~CopyFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

absl::StatusOr<std::string> CopyFolder::StorePath() {
  const MutexLock lock(mutex_);
  if (path_.empty()) {
    std::error_code error;
    std::string pattern = (fs::temp_directory_path(error) / "motiondb-copies-XXXXXX").string();
    if (error || mkdtemp(pattern.data()) == nullptr) {
      return absl::UnavailableError(fmt::format(
          "cannot create a folder for temporary files, '{}': {} (TMPDIR selects another)", pattern,
          error ? error.message() : std::strerror(errno)));
    }
    path_ = std::move(pattern);
  }
  return path_ + "/store";
}

void DeleteStaleCopies(const std::string& store_path) {
  const fs::path path(store_path);
  std::error_code ignored;
  std::vector<fs::path> stale;
  for (const fs::directory_entry& entry : fs::directory_iterator(path.parent_path(), ignored)) {
    if (IsOfCopy(entry.path().filename().string(), path)) stale.push_back(entry.path());
  }
  for (const fs::path& file : stale) fs::remove(file, ignored);
}

absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled) {
  sqlite3_backup* const copy = sqlite3_backup_init(HandleOf(to), "main", HandleOf(from), "main");
  if (copy == nullptr) return SqliteError(HandleOf(to), sqlite3_extended_errcode(HandleOf(to)));
  int code = SQLITE_OK;
  bool stopped = false;
  while (code == SQLITE_OK && !stopped) {
    stopped = cancelled && cancelled();
    if (!stopped) code = sqlite3_backup_step(copy, kPagesAtOnce);
  }
  // Rolls back unless the last step finished the copy.
  const int finished = sqlite3_backup_finish(copy);
  if (stopped) return absl::CancelledError("cancelled while the store was copied");
  if (code == SQLITE_DONE) code = finished;
  if (code != SQLITE_OK) return SqliteError(HandleOf(to), code);
  return absl::OkStatus();
}

}  // namespace motiondb::storage
