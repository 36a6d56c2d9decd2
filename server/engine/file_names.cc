#include "server/engine/file_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxIdLength = 120;

bool IsIdCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.';
}

// The letters of U+00C0 to U+017F (Latin-1 Supplement and Latin Extended-A) without accents.
constexpr char32_t kFirstAccented = 0xC0;
constexpr std::string_view kWithoutAccents =
    "AAAAAAACEEEEIIIIDNOOOOOxOUUUUYTsaaaaaaaceeeeiiiidnooooo_ouuuuyty"
    "AaAaAaCcCcCcCcDdDdEeEeEeEeEeGgGgGgGgHhHhIiIiIiIiIiIiJjKkkLlLlLlLlLlNnNnNnnNnOoOoOoOo"
    "RrRrRrSsSsSsSsTtTtTtUuUuUuUuUuUuWwYyYZzZzZzs";
static_assert(kWithoutAccents.size() == 0x180 - kFirstAccented);

// Returns what stands for a character in an id.
std::string InId(text::Character character) {
  constexpr char32_t kEndOfAscii = 0x80;
  const char32_t code = character.code;
  if (character.bytes == 0) return "_";
  if (code < kEndOfAscii) {
    const auto c = static_cast<char>(code);
    return {IsIdCharacter(c) ? c : '_'};
  }
  if (code >= kFirstAccented && code - kFirstAccented < kWithoutAccents.size()) {
    return {kWithoutAccents[code - kFirstAccented]};
  }
  const bool is_combining = code >= 0x300 && code <= 0x36F;
  return is_combining ? "" : fmt::format("u{:04x}", static_cast<std::uint32_t>(code));
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
  for (std::string_view rest = name; !rest.empty();) {
    const text::Character character = text::FirstCharacter(rest);
    const std::string part = InId(character);
    if (id.size() + part.size() > kMaxIdLength) break;
    id += part;
    rest.remove_prefix(std::max<std::size_t>(1, character.bytes));
  }
  return id.empty() ? "clip" : id;
}

}  // namespace motiondb::server
