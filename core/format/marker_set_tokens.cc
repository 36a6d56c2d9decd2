#include "core/format/marker_set_tokens.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<std::vector<Token>> Tokens(std::string_view line) {
  std::vector<Token> tokens;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == ' ' || line[i] == '\t') {
      ++i;
    } else if (line[i] == '#') {
      break;
    } else if (line[i] == '"') {
      Token name{.quoted = true};
      for (bool open = true; open;) {
        const std::size_t end = line.find('"', ++i);
        if (end == std::string_view::npos) return InvalidArgument("expected a closing quote");
        name.text += line.substr(i, end - i);
        i = end + 1;
        open = line.substr(i).starts_with('"');  // "" is a quote in the name
        if (open) name.text += '"';
      }
      tokens.push_back(std::move(name));
    } else {
      const std::size_t end = std::min(line.find_first_of(" \t#", i), line.size());
      tokens.push_back({std::string(line.substr(i, end - i)), false});
      i = end;
    }
  }
  return tokens;
}

std::string_view NextLine(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, end);
  const bool crlf = text.substr(end).starts_with("\r\n");
  text.remove_prefix(std::min(text.size(), end + (crlf ? 2 : 1)));
  return line;
}

std::optional<double> Number(const Token& token) {
  double value = 0;
  const char* end = token.text.data() + token.text.size();
  const auto parsed = std::from_chars(token.text.data(), end, value);
  if (token.quoted || parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(value)) {
    return std::nullopt;
  }
  return value;
}

std::string QuotedName(const std::string& name) {
  const bool plain = !name.empty() && name.find_first_of(" \t#\"=+") == std::string::npos &&
                     !Number({name, false}) && name != "offset";
  if (plain) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace motiondb::core
