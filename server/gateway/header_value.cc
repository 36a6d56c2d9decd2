#include "server/gateway/header_value.h"

#include <algorithm>
#include <string>

#include "text/utf8.h"

namespace motiondb::server {

std::string_view Trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string_view TakeItem(std::string_view& list, char separator) {
  const auto end = std::min(list.find(separator), list.size());
  const std::string_view item = list.substr(0, end);
  list.remove_prefix(std::min(end + 1, list.size()));
  return Trimmed(item);
}

bool AcceptsGzip(std::string_view list) {
  while (!list.empty()) {
    const std::string item = text::LowerCase(TakeItem(list, ','));
    const auto semicolon = std::min(item.find(';'), item.size());
    if (Trimmed(std::string_view(item).substr(0, semicolon)) != "gzip") continue;
    const auto quality = item.find("q=", semicolon);
    return quality == std::string::npos ||
           item.find_first_of("123456789", quality) != std::string::npos;
  }
  return false;
}

}  // namespace motiondb::server
