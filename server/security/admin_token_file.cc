#include "server/security/admin_token_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "absl/strings/ascii.h"
#include "core/motion/error.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kShortest = 20;

}  // namespace

absl::StatusOr<std::string> ReadAdminToken(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0) {
    return core::InvalidArgument("{}: {}", path, std::strerror(errno));
  }
  if ((status.st_mode & S_IROTH) != 0) {
    return core::InvalidArgument(
        "{}: everybody on this machine can read it; expected mode 0600 or 0640", path);
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return core::InvalidArgument("{}: cannot be read", path);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  absl::StripAsciiWhitespace(&text);
  if (text.size() < kShortest) {
    return core::InvalidArgument("{}: expected a token of at least {} characters", path, kShortest);
  }
  return text;
}

}  // namespace motiondb::server
