#include "server/security/text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/motion/error.h"

namespace motiondb::server {

absl::StatusOr<std::string> ReadTextFile(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  // An empty file counts as one that nothing could be written from, without an error's number.
  if (!file || (!(text << file.rdbuf()) && errno != 0)) {
    return core::InvalidArgument("{}: cannot be read: {}", path, std::strerror(errno));
  }
  return text.str();
}

}  // namespace motiondb::server
