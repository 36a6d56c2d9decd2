#include "server/engine/file_names.h"

#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxIdLength = 120;

bool IsIdCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

}  // namespace

std::string WithoutFolders(std::string_view path) {
  const std::size_t slash = path.find_last_of("/\\");
  return std::string(slash == path.npos ? path : path.substr(slash + 1));
}

std::string ClipIdFromFileName(std::string_view file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::string id;
  for (const char c : file_name.substr(0, dot)) {
    if (id.size() == kMaxIdLength) break;
    if (IsIdCharacter(c)) {
      id += c;
    } else if (!text::IsContinuationByte(c)) {
      id += '_';  // one for all bytes of a UTF-8 character
    }
  }
  return id.empty() ? "clip" : id;
}

}  // namespace motiondb::server
