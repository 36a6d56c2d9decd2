#include "storage/sqlite/store_disk.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::storage {
namespace {

std::string Mebibytes(std::int64_t bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1 << 20));
}

}  // namespace

absl::StatusOr<std::int64_t> DiskReserve::FreeBytes() const {
  struct statvfs disk {};
  if (statvfs(path_.c_str(), &disk) != 0) {
    return absl::UnavailableError(
        fmt::format("cannot read the free disk space of '{}': {}", path_, std::strerror(errno)));
  }
  // f_bavail does not include blocks that are reserved for the superuser.
  return static_cast<std::int64_t>(disk.f_bavail * disk.f_frsize);
}

absl::StatusOr<DiskReserve::Room> DiskReserve::Look(Connection& writer) const {
  Room room;
  MOTIONDB_ASSIGN_OR_RETURN(room.free, FreeBytes());
  std::error_code error;
  const auto log = std::filesystem::file_size(LogPath(path_), error);
  if (!error) room.log = static_cast<std::int64_t>(log);
  MOTIONDB_ASSIGN_OR_RETURN(const auto pages, writer.QueryInteger("PRAGMA freelist_count"));
  MOTIONDB_ASSIGN_OR_RETURN(const auto page_bytes, writer.QueryInteger("PRAGMA page_size"));
  room.freed = pages * page_bytes;
  return room;
}

std::int64_t DiskReserve::Needed(const Room& room, std::int64_t added_bytes) const {
  const std::int64_t grows = std::max<std::int64_t>(added_bytes - room.freed, 0);
  return room.log + added_bytes + grows + bytes_;
}

absl::Status DiskReserve::Check(Connection& writer, std::int64_t added_bytes) const {
  if (is_off()) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(Room room, Look(writer));
  if (room.free < Needed(room, added_bytes) && room.log > 0) {
    CheckpointLog(writer);
    MOTIONDB_ASSIGN_OR_RETURN(room, Look(writer));
  }
  const std::int64_t needed = Needed(room, added_bytes);
  if (room.free >= needed) return absl::OkStatus();
  return Refuse(room.free, needed - bytes_);
}

absl::Status DiskReserve::CheckTemporaryFile(std::int64_t added_bytes) const {
  if (is_off()) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t free, FreeBytes());
  return free >= added_bytes + bytes_ ? absl::OkStatus() : Refuse(free, added_bytes);
}

absl::Status DiskReserve::Refuse(std::int64_t free, std::int64_t added_bytes) const {
  return core::WithReason(
      "DISK_FULL", absl::ResourceExhaustedError(fmt::format(
                       "{} free on the disk of '{}', expected {}: {} for the log and the new data, "
                       "and a reserve of "
                       "{} for deletions (--disk-reserve-mib); free disk space or delete clips",
                       Mebibytes(free), path_, Mebibytes(added_bytes + bytes_),
                       Mebibytes(added_bytes), Mebibytes(bytes_))));
}

bool DiskReserve::HasReserve() const {
  struct statvfs disk {};
  if (is_off() || statvfs(path_.c_str(), &disk) != 0) return true;
  return static_cast<std::int64_t>(disk.f_bavail * disk.f_frsize) > bytes_;
}

void DiskReserve::GiveBack(Connection& writer) const {
  if (is_off()) return;
  const auto room = Look(writer);
  if (room.ok() && room->free < bytes_ && room->log > 0) CheckpointLog(writer);
}

namespace {

namespace fs = std::filesystem;

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

}  // namespace motiondb::storage
