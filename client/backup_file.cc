#include "client/backup_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

namespace motiondb::client {

namespace {

constexpr size_t kDigestBytes = 32;

// Converts errno.
absl::Status WriteError(const std::string& path) {
  return absl::UnknownError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

absl::Status AlreadyExists(const std::filesystem::path& path) {
  return absl::AlreadyExistsError(fmt::format("{}: already exists", path.string()));
}

// Syncs a folder, so that its entries survive a power cut.
bool SyncFolder(const std::filesystem::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return errno == EACCES;  // a folder can be writable but not readable
  // EINVAL: the file system does not support syncing a folder.
  const bool synced = fsync(descriptor) == 0 || errno == EINVAL;
  const int error = errno;
  close(descriptor);
  errno = error;
  return synced;
}

}  // namespace

void BackupFile::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

BackupFile::BackupFile() : digest_(EVP_MD_CTX_new()) {
  EVP_DigestInit_ex(digest_.get(), EVP_sha256(), nullptr);
}

BackupFile::~BackupFile() = default;

absl::Status BackupFile::Open(const std::filesystem::path& path, bool overwrite) {
  std::error_code ignored;
  if (!overwrite && std::filesystem::exists(path, ignored)) return AlreadyExists(path);
  if (const absl::Status free = CheckReplaceable(path); !free.ok()) return free;
  path_ = path;
  overwrite_ = overwrite;
  // Only the owner can read a backup: it contains all motion and the hashes of tokens.
  auto file = OutputFile::Create(path, 0600);
  if (!file.ok()) return file.status();
  file_ = *std::move(file);
  return absl::OkStatus();
}

absl::Status BackupFile::Append(const std::string& block) {
  if (const absl::Status written = file_->Append(block); !written.ok()) return written;
  bytes_ += static_cast<std::int64_t>(block.size());
  tail_ += block;
  if (tail_.size() > kDigestBytes) {
    const size_t ready = tail_.size() - kDigestBytes;
    EVP_DigestUpdate(digest_.get(), tail_.data(), ready);
    tail_.erase(0, ready);
  }
  return absl::OkStatus();
}

absl::Status BackupFile::Complete() {
  std::string digest(kDigestBytes, '\0');
  EVP_DigestFinal_ex(digest_.get(), reinterpret_cast<unsigned char*>(digest.data()), nullptr);
  if (digest != tail_) {
    return absl::DataLossError(fmt::format(
        "{}: the received backup is corrupt: its checksum does not match", path_.string()));
  }
  if (const absl::Status synced = file_->Flush(/*to_disk=*/true); !synced.ok()) return synced;
  // Checks again, because a server may have been started on the file meanwhile.
  if (const absl::Status free = CheckReplaceable(path_); overwrite_ && !free.ok()) return free;
  if (const absl::Status named = file_->Commit(overwrite_); !named.ok()) return named;
  const std::filesystem::path folder = path_.parent_path();
  return SyncFolder(folder.empty() ? "." : folder) ? absl::OkStatus() : WriteError(path_.string());
}

namespace {

// A store begins with SQLite's header and the application id; a backup also ends with a mark and a
// checksum (docs/storage_format.md).
constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);
constexpr off_t kApplicationIdOffset = 68;
constexpr std::string_view kApplicationId = "mtdb";
constexpr std::string_view kBackupMark = "mtdbback";
constexpr off_t kChecksumBytes = 32;

absl::Status Refusal(const std::filesystem::path& path, std::string_view what) {
  return absl::FailedPreconditionError(
      fmt::format("{}: {}; the file was not changed", path.string(), what));
}

const char* KindOf(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISLNK(mode)) return "a symbolic link";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

bool HasAt(int file, off_t offset, std::string_view expected) {
  std::string bytes(expected.size(), '\0');
  const ssize_t got = offset < 0 ? -1 : pread(file, bytes.data(), bytes.size(), offset);
  return got == static_cast<ssize_t>(expected.size()) && bytes == expected;
}

bool IsStore(int file) {
  return HasAt(file, 0, kSqliteMagic) && HasAt(file, kApplicationIdOffset, kApplicationId);
}

// Returns whether the file ends like a backup.
bool EndsLikeBackup(int file, off_t size) {
  return HasAt(file, size - kChecksumBytes - static_cast<off_t>(kBackupMark.size()), kBackupMark);
}

// Returns the path of a lock file or WAL beside the file, which a server creates, or an empty
// string.
std::string CompanionOfStore(const std::filesystem::path& path) {
  for (const char* const suffix : {"-lock", "-wal"}) {
    const std::string companion = path.string() + suffix;
    struct stat status {};
    if (lstat(companion.c_str(), &status) == 0) return companion;
  }
  return "";
}

}  // namespace

absl::Status CheckReplaceable(const std::filesystem::path& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return absl::OkStatus();
    return Refusal(path, fmt::format("cannot be inspected: {}", std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) {
    return Refusal(
        path, fmt::format("is {}, and only regular files are replaced", KindOf(status.st_mode)));
  }
  if (const std::string companion = CompanionOfStore(path); !companion.empty()) {
    return Refusal(path, fmt::format("is or was a server's store: {} exists", companion));
  }
  const int file = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) {
    return Refusal(
        path, fmt::format("cannot be read and may be a server's store: {}", std::strerror(errno)));
  }
  const bool is_store = IsStore(file);
  const bool is_backup = is_store && EndsLikeBackup(file, status.st_size);
  close(file);
  if (is_backup || status.st_size == 0) return absl::OkStatus();
  return Refusal(path, is_store ? "is a motiondb store, not a backup of one"
                                : "is not a backup of a motiondb store");
}

}  // namespace motiondb::client
