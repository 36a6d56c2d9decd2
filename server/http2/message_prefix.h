// The prefix of a message in gRPC and of an envelope in the Connect protocol.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace motiondb::server {

// Precedes each message: a byte of flags, of which 1 means compressed, and its length, big-endian.
inline constexpr std::size_t kMessagePrefixBytes = 5;
using MessagePrefix = std::array<std::uint8_t, kMessagePrefixBytes>;

inline MessagePrefix MakeMessagePrefix(std::uint32_t length) {
  return {0, static_cast<std::uint8_t>(length >> 24), static_cast<std::uint8_t>(length >> 16),
          static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length)};
}

inline bool IsCompressed(const MessagePrefix& prefix) { return prefix[0] != 0; }

inline std::uint32_t MessageLength(const MessagePrefix& prefix) {
  return std::uint32_t{prefix[1]} << 24 | std::uint32_t{prefix[2]} << 16 |
         std::uint32_t{prefix[3]} << 8 | std::uint32_t{prefix[4]};
}

}  // namespace motiondb::server
