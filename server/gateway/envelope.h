// Envelopes of streams in the Connect protocol: a byte of flags, the length as 4 bytes
// (big-endian), and a message.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

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
