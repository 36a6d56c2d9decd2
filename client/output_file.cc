#include "client/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <utility>

#include "text/display_text.h"

namespace motiondb::client {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = std::size_t{64} << 10;
constexpr int kMaxAttempts = 100;  // to find a free name

fs::path FolderOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Returns a random name in the folder of `path`. It is short, even if the name in `path` is long.
std::string TemporaryName(const fs::path& path) {
  std::random_device random;
  const std::uint64_t number = (std::uint64_t{random()} << 32) | random();
  return (FolderOf(path) / fmt::format(".motiondb-{:016x}", number)).string();
}

// Calls `take` with random names until it returns 0 or fails with an error other than EEXIST.
// Returns the name, or an empty string after a failure.
template <typename Take>
std::string FirstFreeName(const fs::path& path, const Take& take) {
  for (int i = 0; i < kMaxAttempts; ++i) {
    std::string name = TemporaryName(path);
    if (take(name.c_str()) == 0) return name;
    if (errno != EEXIST) break;
  }
  return "";
}

std::string DescriptorLink(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

// Opens an unnamed file that can be linked later; returns -1 if the system does not support it.
int OpenWithoutName(const fs::path& folder, mode_t mode) {
  const int descriptor = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, mode);
  if (descriptor < 0) return -1;
  if (access(DescriptorLink(descriptor).c_str(), F_OK) == 0) return descriptor;
  close(descriptor);
  return -1;
}

bool WriteAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// Reads up to `bytes.size()` bytes; returns an empty view at the end or after an error.
std::string_view ReadAt(int file, off_t offset, std::string& bytes) {
  const ssize_t got = pread(file, bytes.data(), bytes.size(), offset);
  return std::string_view(bytes).substr(0, got < 0 ? 0 : static_cast<std::size_t>(got));
}

bool SameBytes(int one, int other) {
  struct stat first {
  }, second{};
  if (fstat(one, &first) != 0 || fstat(other, &second) != 0) return false;
  if (!S_ISREG(second.st_mode) || first.st_size != second.st_size) return false;
  std::string a(kBufferBytes, '\0'), b(kBufferBytes, '\0');
  for (off_t offset = 0; offset < first.st_size;) {
    const std::string_view read = ReadAt(one, offset, a);
    if (read.empty() || read != ReadAt(other, offset, b)) return false;
    offset += static_cast<off_t>(read.size());
  }
  return true;
}

}  // namespace

OutputFile::OutputFile(fs::path path, int descriptor, std::string temporary)
    : path_(std::move(path)), descriptor_(descriptor), temporary_(std::move(temporary)) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      temporary_(std::exchange(other.temporary_, "")),
      buffer_(std::move(other.buffer_)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(temporary_, other.temporary_);
  std::swap(buffer_, other.buffer_);
  return *this;
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

absl::Status OutputFile::WriteError() const {
  return absl::UnknownError(
      fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
}

absl::StatusOr<OutputFile> OutputFile::Create(const fs::path& path, mode_t mode) {
  OutputFile file(path, OpenWithoutName(FolderOf(path), mode), "");
  if (file.descriptor_ >= 0) return file;
  file.temporary_ = FirstFreeName(path, [&](const char* name) {
    file.descriptor_ = open(name, O_CREAT | O_EXCL | O_NOFOLLOW | O_RDWR | O_CLOEXEC, mode);
    return file.descriptor_ < 0 ? -1 : 0;
  });
  if (file.descriptor_ < 0) return file.WriteError();
  return file;
}

absl::StatusOr<OutputFile> OutputFile::CreateReplacing(const fs::path& path) {
  auto file = Create(path);
  if (!file.ok()) return file;
  if (absl::Status replaceable = file->CheckReplaceable(); !replaceable.ok()) return replaceable;
  return file;
}

absl::Status OutputFile::Append(std::string_view bytes) {
  buffer_ += bytes;
  return buffer_.size() < kBufferBytes ? absl::OkStatus() : Flush();
}

absl::Status OutputFile::Flush(bool to_disk) {
  if (!WriteAll(descriptor_, buffer_)) return WriteError();
  buffer_.clear();
  return to_disk && fsync(descriptor_) != 0 ? WriteError() : absl::OkStatus();
}

absl::StatusOr<bool> OutputFile::HasSameContent() {
  if (absl::Status flushed = Flush(); !flushed.ok()) return flushed;
  const int existing = open(path_.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (existing < 0) return false;
  const bool same = SameBytes(descriptor_, existing);
  close(existing);
  return same;
}

absl::Status OutputFile::Commit(bool replace) {
  if (absl::Status flushed = Flush(); !flushed.ok()) return flushed;
  absl::Status named = replace ? RenameReplacing() : RenameIfFree();
  if (!named.ok()) return named;
  temporary_.clear();
  // A network file system may report a full disk only at close.
  return close(std::exchange(descriptor_, -1)) == 0 ? absl::OkStatus() : WriteError();
}

absl::Status OutputFile::CheckReplaceable() const {
  struct stat existing {};
  if (lstat(path_.c_str(), &existing) != 0) {
    return errno == ENOENT ? absl::OkStatus() : WriteError();  // such as a name that is too long
  }
  if (S_ISREG(existing.st_mode) || S_ISLNK(existing.st_mode)) return absl::OkStatus();
  return absl::FailedPreconditionError(fmt::format(
      "{}: is neither a regular file nor a symbolic link; choose another name", path_.string()));
}

absl::Status OutputFile::RenameReplacing() {
  if (absl::Status replaceable = CheckReplaceable(); !replaceable.ok()) return replaceable;
  // linkat cannot replace an existing name, but rename can: give the unnamed file a temporary name.
  if (temporary_.empty()) {
    temporary_ = FirstFreeName(path_, [&](const char* name) {
      return linkat(AT_FDCWD, DescriptorLink(descriptor_).c_str(), AT_FDCWD, name,
                    AT_SYMLINK_FOLLOW);
    });
    if (temporary_.empty()) return WriteError();
  }
  return rename(temporary_.c_str(), path_.c_str()) == 0 ? absl::OkStatus() : WriteError();
}

absl::Status OutputFile::RenameIfFree() {
  const int renamed = temporary_.empty() ? linkat(AT_FDCWD, DescriptorLink(descriptor_).c_str(),
                                                  AT_FDCWD, path_.c_str(), AT_SYMLINK_FOLLOW)
                                         : renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD,
                                                     path_.c_str(), RENAME_NOREPLACE);
  if (renamed == 0) return absl::OkStatus();
  struct stat existing {};
  if (errno == EEXIST || lstat(path_.c_str(), &existing) == 0) {
    return absl::AlreadyExistsError(fmt::format("{}: already exists", path_.string()));
  }
  // Some file systems do not support RENAME_NOREPLACE.
  const bool can_rename = !temporary_.empty() && (errno == EINVAL || errno == ENOSYS);
  return can_rename ? RenameReplacing() : WriteError();
}

absl::Status CheckFileNameFromServer(const std::string& name) {
  const bool hides = name.empty() || name[0] == '.' || name[0] == '-';
  if (!hides && name.find_first_of("/\\") == std::string::npos && text::DisplayText(name) == name) {
    return absl::OkStatus();
  }
  return absl::DataLossError(
      fmt::format("the server sent the file name \"{}\"; expected no folders, no control "
                  "characters, and neither "
                  "'.' nor '-' at the beginning. Nothing was written",
                  name));
}

absl::Status CheckCanWrite(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths) {
    if (path.empty()) continue;
    if (const auto file = OutputFile::CreateReplacing(path); !file.ok()) return file.status();
  }
  return absl::OkStatus();
}

absl::Status WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes) {
  auto file = OutputFile::CreateReplacing(path);
  if (!file.ok()) return file.status();
  if (const absl::Status written = file->Append(bytes); !written.ok()) return written;
  return file->Commit(/*replace=*/true);
}

}  // namespace motiondb::client
