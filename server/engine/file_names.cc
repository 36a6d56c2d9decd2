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

std::string ClipIdFromFileName(std::string_view file_name, std::string_view take) {
  for (const std::string_view gzip : {".gz", ".GZ"}) {
    if (file_name.ends_with(gzip)) file_name.remove_suffix(gzip.size());
  }
  std::string name(file_name.substr(0, file_name.rfind('.')));
  if (!take.empty()) name.append("-").append(take);
  std::string id;
  for (const char c : name) {
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
