#include "server/security/memory_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

absl::StatusOr<int> Write(const std::string& contents) {
  const int descriptor = memfd_create("motiondb-tls", MFD_CLOEXEC);
  if (descriptor < 0) {
    return absl::InternalError(fmt::format("a file in memory: {}", std::strerror(errno)));
  }
  std::size_t written = 0;
  while (written < contents.size()) {
    const ssize_t count = write(descriptor, contents.data() + written, contents.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      close(descriptor);
      return absl::InternalError(fmt::format("a file in memory: {}", std::strerror(errno)));
    }
    written += static_cast<std::size_t>(count);
  }
  return descriptor;
}

}  // namespace

absl::StatusOr<MemoryFile> MemoryFile::Make(const std::string& contents) {
  MOTIONDB_ASSIGN_OR_RETURN(const int descriptor, Write(contents));
  return MemoryFile(descriptor);
}

MemoryFile::MemoryFile(MemoryFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string MemoryFile::path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

absl::Status MemoryFile::Replace(const std::string& contents) {
  MOTIONDB_ASSIGN_OR_RETURN(const int descriptor, Write(contents));
  const bool replaced = dup3(descriptor, descriptor_, O_CLOEXEC) >= 0;
  const int error = errno;
  close(descriptor);
  if (replaced) return absl::OkStatus();
  return absl::InternalError(fmt::format("a file in memory: {}", std::strerror(error)));
}

}  // namespace motiondb::server
