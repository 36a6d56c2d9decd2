#include "client/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace motiondb::client {
namespace {

// Converts errno.
absl::Status Unreadable(const std::filesystem::path& path) {
  if (errno == ENOENT) return absl::NotFoundError(fmt::format("{}: no such file", path.string()));
  return absl::UnknownError(
      fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
}

std::string LimitText(std::size_t bytes) {
  return bytes >> 20 > 0 ? fmt::format("{} MiB", bytes >> 20) : fmt::format("{} KiB", bytes >> 10);
}

absl::Status TooLarge(const std::filesystem::path& path, std::size_t max_bytes) {
  return absl::InvalidArgumentError(fmt::format(
      "{}: is larger than {}, the maximum for such a file", path.string(), LimitText(max_bytes)));
}

}  // namespace

InputFile::InputFile(std::filesystem::path path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

absl::StatusOr<InputFile> InputFile::Open(const std::filesystem::path& path) {
  InputFile file(path, open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.descriptor_ < 0 || fstat(file.descriptor_, &status) != 0) return Unreadable(path);
  if (S_ISDIR(status.st_mode)) {
    return absl::InvalidArgumentError(fmt::format("{}: is a folder, not a file", path.string()));
  }
  if (S_ISREG(status.st_mode)) file.size_ = static_cast<std::uint64_t>(status.st_size);
  return file;
}

absl::Status InputFile::Read(std::size_t max_bytes, std::string& block) {
  block.resize(max_bytes);
  std::size_t got = 0;
  while (got < max_bytes) {
    const ssize_t count = read(descriptor_, block.data() + got, max_bytes - got);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return Unreadable(path_);
    if (count == 0) break;
    got += static_cast<std::size_t>(count);
  }
  block.resize(got);
  return absl::OkStatus();
}

absl::StatusOr<std::string> ReadWholeFile(const std::filesystem::path& path,
                                          std::size_t max_bytes) {
  constexpr std::size_t kReadBytes = std::size_t{1} << 20;
  auto file = InputFile::Open(path);
  if (!file.ok()) return file.status();
  if (file->size() && *file->size() > max_bytes) return TooLarge(path, max_bytes);
  std::string bytes, block;
  do {
    // Reads at most one byte more than allowed, to detect a file that is too large.
    const std::size_t block_bytes = std::min(kReadBytes, max_bytes + 1 - bytes.size());
    if (const absl::Status read = file->Read(block_bytes, block); !read.ok()) return read;
    bytes += block;
    if (bytes.size() > max_bytes) return TooLarge(path, max_bytes);
  } while (!block.empty());
  return bytes;
}

}  // namespace motiondb::client
