#include "client/backup_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "client/replaceable_file.h"

namespace motiondb::client {
namespace {

constexpr size_t kDigestBytes = 32;

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

BackupFile::~BackupFile() = default;

absl::Status BackupFile::Open(const std::filesystem::path& path, bool overwrite) {
  std::error_code ignored;
  if (!overwrite && std::filesystem::exists(path, ignored)) return AlreadyThere(path);
  if (const absl::Status free = CheckReplaceable(path); !free.ok()) return free;
  path_ = path;
  overwrite_ = overwrite;
  // A backup holds all motion and the hashes of tokens, and is its owner's alone.
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
    return absl::DataLossError(
        fmt::format("{}: the backup did not arrive whole: its checksum is wrong", path_.string()));
  }
  if (const absl::Status synced = file_->Flush(/*to_disk=*/true); !synced.ok()) return synced;
  // Again, for a server may have been started on it meanwhile.
  if (const absl::Status free = CheckReplaceable(path_); overwrite_ && !free.ok()) return free;
  if (const absl::Status named = file_->Commit(overwrite_); !named.ok()) return named;
  const std::filesystem::path folder = path_.parent_path();
  return SyncFolder(folder.empty() ? "." : folder) ? absl::OkStatus() : Failed(path_.string());
}

}  // namespace motiondb::client
