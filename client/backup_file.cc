#include "client/backup_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

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
  if (!overwrite && std::filesystem::exists(path, ignored)) {
    return absl::AlreadyExistsError(fmt::format("{}: exists already", path.string()));
  }
  path_ = path;
  part_ = path.string() + ".part";
  // A backup holds all motion and the hashes of tokens: it is its owner's alone.
  file_ = open(part_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  return file_ < 0 ? WriteFailed() : absl::OkStatus();
}

absl::Status BackupFile::Append(const std::string& block) {
  if (!WriteAll(file_, block)) return WriteFailed();
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
  if (fsync(file_) != 0) return WriteFailed();
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) return absl::UnknownError(fmt::format("{}: {}", path_.string(), error.message()));
  close(file_);
  file_ = -1;
  return absl::OkStatus();
}

absl::Status BackupFile::WriteFailed() const {
  return absl::UnknownError(
      fmt::format("{}: cannot be written: {}", part_.string(), std::strerror(errno)));
}

}  // namespace motiondb::client
