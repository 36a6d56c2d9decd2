#include "server/security/operator_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>

#include "absl/strings/ascii.h"
#include "core/motion/error.h"

namespace motiondb::server {

absl::StatusOr<std::string> ReadTextFile(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  // For an empty file operator<< fails, but errno stays 0.
  if (!file || (!(text << file.rdbuf()) && errno != 0)) {
    return core::InvalidArgument("{}: cannot be read: {}", path, std::strerror(errno));
  }
  return text.str();
}

namespace {

constexpr std::size_t kMinTokenLength = 20;

}  // namespace

absl::StatusOr<std::string> ReadAdminToken(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) != 0) {
    return core::InvalidArgument("{}: {}", path, std::strerror(errno));
  }
  if (const std::string_view fault = ModeFault(status.st_mode); !fault.empty()) {
    return core::InvalidArgument("{}: {}; expected mode {}", path, fault, kSecretModes);
  }
  MOTIONDB_ASSIGN_OR_RETURN(std::string text, ReadTextFile(path));
  absl::StripAsciiWhitespace(&text);
  if (text.size() < kMinTokenLength) {
    return core::InvalidArgument("{}: expected a token of at least {} characters", path,
                                 kMinTokenLength);
  }
  if (!std::ranges::all_of(text, absl::ascii_isprint)) {
    return core::InvalidArgument(
        "{}: expected a token on one line, of printable ASCII characters; create one with "
        "`openssl rand -hex 32`",
        path);
  }
  return text;
}

}  // namespace motiondb::server
