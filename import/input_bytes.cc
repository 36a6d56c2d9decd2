#include "import/input_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/cleanup/cleanup.h"

namespace motiondb::importer {

absl::StatusOr<InputBytes> InputBytes::Open(const std::string& path, std::size_t max_bytes) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    return errno == ENOENT ? absl::NotFoundError("no such file")
                           : absl::InvalidArgumentError(std::strerror(errno));
  }
  const absl::Cleanup close_file = [file] { close(file); };
  struct stat status {};
  if (fstat(file, &status) != 0) return absl::InvalidArgumentError(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return absl::InvalidArgumentError("expected a regular file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > max_bytes) {
    return absl::InvalidArgumentError(fmt::format("expected at most {} MiB, got {:.1f} MiB",
                                                  max_bytes >> 20,
                                                  static_cast<double>(size) / (1 << 20)));
  }
  InputBytes input;
  if (size == 0) return input;
  void* const data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
  if (data == MAP_FAILED) return absl::InvalidArgumentError(std::strerror(errno));
  input.data_ = static_cast<const char*>(data);
  input.size_ = size;
  return input;
}

InputBytes::InputBytes(InputBytes&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

InputBytes& InputBytes::operator=(InputBytes&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

InputBytes::~InputBytes() {
  if (data_ != nullptr) munmap(const_cast<char*>(data_), size_);
}

}  // namespace motiondb::importer
