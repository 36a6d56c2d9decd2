#include "storage/sqlite/file_identity.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "core/motion/error.h"

namespace motiondb::storage {

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
