#include "server/engine/file_names.h"

#include <cstdint>

namespace motiondb::server {
namespace {

constexpr std::size_t kLongestId = 120;

bool BelongsInId(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

// The second and later bytes of a UTF-8 character: the first has stood for all of it.
bool ContinuesCharacter(char c) { return (static_cast<std::uint8_t>(c) & 0xc0) == 0x80; }

}  // namespace

std::string WithoutFolders(std::string_view path) {
  const std::size_t slash = path.find_last_of("/\\");
  return std::string(slash == path.npos ? path : path.substr(slash + 1));
}

std::string ClipIdFromFileName(std::string_view file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::string id;
  for (const char c : file_name.substr(0, dot)) {
    if (id.size() == kLongestId) break;
    if (BelongsInId(c)) {
      id += c;
    } else if (!ContinuesCharacter(c)) {
      id += '_';
    }
  }
  return id.empty() ? "clip" : id;
}

}  // namespace motiondb::server
