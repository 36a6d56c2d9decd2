#include "client/backup_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "client/replaceable_file.h"

namespace motiondb::client {
namespace {

constexpr size_t kDigestBytes = 32;

bool WriteAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return true;
}

// By errno.
absl::Status Failed(const std::string& path) {
  return absl::UnknownError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

absl::Status AlreadyThere(const std::filesystem::path& path) {
  return absl::AlreadyExistsError(fmt::format("{}: exists already", path.string()));
}

// What a folder lists stays so after a power cut.
bool SyncFolder(const std::filesystem::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return errno == EACCES;  // one may write to it and not list it
  // Some file systems know no syncing of folders, and say so.
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

BackupFile::~BackupFile() {
  if (file_ < 0) return;
  close(file_);
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

absl::Status BackupFile::Open(const std::filesystem::path& path, bool overwrite) {
  std::error_code ignored;
  if (!overwrite && std::filesystem::exists(path, ignored)) return AlreadyThere(path);
  if (const absl::Status free = CheckReplaceable(path); !free.ok()) return free;
  path_ = path;
  overwrite_ = overwrite;
  part_ = path.string() + ".part-XXXXXX";
  // A new file, with mode 0600: a backup holds all motion and the hashes of tokens, and is its
  // owner's alone.
  file_ = mkostemp(part_.data(), O_CLOEXEC);
  return file_ < 0 ? Failed(part_) : absl::OkStatus();
}

absl::Status BackupFile::Append(const std::string& block) {
  if (!WriteAll(file_, block)) return Failed(part_);
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
    return absl::DataLossError(
        fmt::format("{}: the backup did not arrive whole: its checksum is wrong", path_.string()));
  }
  if (fsync(file_) != 0) return Failed(part_);
  if (const absl::Status named = GiveName(); !named.ok()) return named;
  close(file_);
  file_ = -1;
  const std::filesystem::path folder = path_.parent_path();
  return SyncFolder(folder.empty() ? "." : folder) ? absl::OkStatus() : Failed(path_.string());
}

absl::Status BackupFile::GiveName() {
  if (!overwrite_) {
    if (renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) == 0) {
      return absl::OkStatus();
    }
    // Not every file system can tell in one step whether the name is free.
    std::error_code ignored;
    const bool is_taken = errno == EEXIST || std::filesystem::exists(path_, ignored);
    if (is_taken) return AlreadyThere(path_);
  }
  // Again, for a server may have been started on it meanwhile.
  if (const absl::Status free = CheckReplaceable(path_); !free.ok()) return free;
  return rename(part_.c_str(), path_.c_str()) == 0 ? absl::OkStatus() : Failed(path_.string());
}

}  // namespace motiondb::client
