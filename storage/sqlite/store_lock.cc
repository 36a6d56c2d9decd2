#include "storage/sqlite/store_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

// Returns the holder's process id from the lock file: " (process 123)", or an empty text.
std::string HolderOf(int file) {
  char text[32];
  const ssize_t size = pread(file, text, sizeof(text), 0);
  return size > 0 ? fmt::format(" (process {})", std::string(text, size)) : "";
}

absl::Status CheckHasOneName(const std::string& store_path) {
  struct stat store {};
  if (stat(store_path.c_str(), &store) != 0 || store.st_nlink <= 1) return absl::OkStatus();
  return core::FailedPrecondition(
      "'{}' has {} names (hard links), expected one: servers on different names could corrupt it; "
      "keep the name that has a log (-wal), if there is one, and remove the others",
      store_path, store.st_nlink);
}

}  // namespace

absl::StatusOr<StoreLock> StoreLock::Acquire(const std::string& store_path, Kind kind) {
  MOTIONDB_RETURN_IF_ERROR(CheckHasOneName(store_path));
  const std::string path = store_path + "-lock";
  const bool shared = kind == Kind::kShared;
  int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0 && shared) {
    const bool can_be_written = errno != EROFS && errno != EACCES;
    file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0 && errno == ENOENT && !can_be_written) return StoreLock(-1);
  }
  if (file < 0) {
    return absl::UnavailableError(
        fmt::format("cannot open the lock file '{}': {}", path, std::strerror(errno)));
  }
  StoreLock lock(file);
  if (flock(file, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) {
      return core::FailedPrecondition(
          "'{}' is in use{}: only one process may open a store, or several read-only", store_path,
          HolderOf(file));
    }
    return absl::UnavailableError(fmt::format("cannot lock '{}': {}", path, std::strerror(errno)));
  }
  // Only for the message above: ignore errors. Shared holders write no process id.
  const std::string holder = shared ? "" : fmt::format("{}", getpid());
  if (ftruncate(file, 0) == 0) static_cast<void>(!pwrite(file, holder.data(), holder.size(), 0));
  return lock;
}

StoreLock::StoreLock(StoreLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

StoreLock& StoreLock::operator=(StoreLock&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

StoreLock::~StoreLock() {
  if (file_ >= 0) close(file_);
}

absl::StatusOr<FileIdentity> GetFileIdentity(const std::string& path) {
  struct stat found {};
  if (stat(path.c_str(), &found) == 0) return FileIdentity{found.st_dev, found.st_ino};
  return absl::UnavailableError(fmt::format("'{}' is gone ({})", path, std::strerror(errno)));
}

absl::Status CheckFileIdentity(const std::string& path, const FileIdentity& file) {
  MOTIONDB_ASSIGN_OR_RETURN(const FileIdentity found, GetFileIdentity(path));
  if (found.device == file.device && found.inode == file.inode) return absl::OkStatus();
  return absl::UnavailableError(fmt::format("'{}' was replaced by another file", path));
}

}  // namespace motiondb::storage
