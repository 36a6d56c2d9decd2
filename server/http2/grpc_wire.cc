#include "server/http2/grpc_wire.h"

#include <algorithm>
#include <charconv>

#include "absl/strings/escaping.h"

namespace motiondb::server {
namespace {

bool IsPrintable(char c) { return c >= 0x20 && c < 0x7f; }

// As grpc-message has it: all but printable ASCII, and '%', as % and two hexadecimal digits.
std::string PercentEncoded(std::string_view text) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    if (IsPrintable(c) && c != '%') {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', kDigits[byte >> 4], kDigits[byte & 0xf]};
  }
  return encoded;
}

// Without padding, as gRPC wants it.
std::string Base64(std::string_view bytes) {
  std::string text = absl::Base64Escape({bytes.data(), bytes.size()});
  while (!text.empty() && text.back() == '=') text.pop_back();
  return text;
}

}  // namespace

MessagePrefix PrefixOf(std::uint32_t length) {
  return {0, static_cast<std::uint8_t>(length >> 24), static_cast<std::uint8_t>(length >> 16),
          static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length)};
}

bool IsCompressed(const MessagePrefix& prefix) { return prefix[0] != 0; }

std::uint32_t LengthIn(const MessagePrefix& prefix) {
  return std::uint32_t{prefix[1]} << 24 | std::uint32_t{prefix[2]} << 16 |
         std::uint32_t{prefix[3]} << 8 | std::uint32_t{prefix[4]};
}

std::optional<std::chrono::nanoseconds> ParseTimeout(std::string_view text) {
  if (text.size() < 2 || text.size() > 9) return std::nullopt;
  std::int64_t count = 0;
  const char* const end = text.data() + text.size() - 1;
  const auto parsed = std::from_chars(text.data(), end, count);
  if (parsed.ec != std::errc() || parsed.ptr != end || count < 0) return std::nullopt;
  using namespace std::chrono;
  switch (text.back()) {
    case 'H':  // more than a year is as good as none, and would not fit
      return hours(std::min<std::int64_t>(count, 24 * 366));
    case 'M':
      return minutes(std::min<std::int64_t>(count, 60 * 24 * 366));
    case 'S':
      return seconds(count);
    case 'm':
      return milliseconds(count);
    case 'u':
      return microseconds(count);
    case 'n':
      return nanoseconds(count);
    default:
      return std::nullopt;
  }
}

HeaderList TrailersOf(const grpc::Status& status) {
  HeaderList trailers = {{"grpc-status", std::to_string(static_cast<int>(status.error_code()))}};
  if (!status.error_message().empty()) {
    trailers.emplace_back("grpc-message", PercentEncoded(status.error_message()));
  }
  if (!status.error_details().empty()) {
    trailers.emplace_back("grpc-status-details-bin", Base64(status.error_details()));
  }
  return trailers;
}

std::string PrintableAscii(std::string_view text) {
  std::string printable(text);
  std::ranges::replace_if(
      printable, [](char c) { return !IsPrintable(c); }, '?');
  return printable;
}

}  // namespace motiondb::server
