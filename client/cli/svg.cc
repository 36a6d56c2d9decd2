#include "client/cli/svg.h"

#include <fmt/format.h>

#include <cmath>

#include "client/cli/utf8.h"

namespace motiondb::client {

std::string SvgText(std::string_view text) {
  const bool readable = IsUtf8(text);
  std::string escaped;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (byte >= 0x80 && !readable) {
      escaped += '?';
    } else if (byte >= 0x20 && byte != 0x7f) {
      escaped += c;
    } else if (c == '\n' || c == '\t') {
      escaped += ' ';
    }
  }
  return escaped;
}

std::string SvgNumber(double value) {
  const bool nothing = !std::isfinite(value) || std::abs(value) < 0.005;
  return fmt::format("{:.2f}", nothing ? 0.0 : value);
}

}  // namespace motiondb::client
