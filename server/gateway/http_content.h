// Values of HTTP headers (RFC 9110), gzip (RFC 1952), and the envelopes of streams in the Connect
// protocol.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Returns the text without spaces and tabs around it.
std::string_view Trimmed(std::string_view text);

// Removes the first item of a list from it, with its separator, and returns it trimmed.
std::string_view TakeItem(std::string_view& list, char separator);

// Returns whether the value of Accept-Encoding contains gzip with a quality above 0.
bool AcceptsGzip(std::string_view list);

// Returns the decompressed bytes. Calls `admit` with the total before it allocates more, at most
// doubling it each time, and returns its error. INVALID_ARGUMENT if the data is not exactly one
// complete gzip member.
absl::StatusOr<std::string> Gunzip(std::string_view bytes,
                                   const std::function<absl::Status(std::int64_t)>& admit);

// Returns the bytes compressed at the fastest level. Throws std::bad_alloc.
std::string Gzip(std::string_view bytes);

// Envelopes of streams: a byte of flags, the length as 4 bytes (big-endian), and a message.

inline constexpr std::uint8_t kCompressed = 1;
inline constexpr std::uint8_t kEndOfStream = 2;

struct Envelope {
  bool compressed = false;
  std::string_view message;
};

// Returns the only envelope of a request. INVALID_ARGUMENT if `body` has none, more than one, a
// truncated one, or one with other flags than kCompressed.
absl::StatusOr<Envelope> ParseEnvelope(std::string_view body);

std::string MakeEnvelope(std::uint8_t flags, std::string_view message);

}  // namespace motiondb::server
