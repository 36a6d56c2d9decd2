// gRPC's wire format in HTTP/2 headers and data ("gRPC over HTTP2").
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/status.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace motiondb::server {

// Precedes each message of gRPC, and each envelope in the Connect protocol: a byte of flags, of
// which 1 means compressed, and its length, big-endian.
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

using HeaderList = std::vector<std::pair<std::string, std::string>>;

// Parses the header `grpc-timeout`: at most 8 digits and a unit, "250m". nullopt if malformed.
std::optional<std::chrono::nanoseconds> ParseTimeout(std::string_view text);

// Returns the trailers of a call: grpc-status, grpc-message and grpc-status-details-bin.
HeaderList MakeTrailers(const grpc::Status& status);

// Replaces everything but printable ASCII by '?': gRPC aborts the process if metadata has other
// characters.
std::string PrintableAscii(std::string_view text);

// Returns the RPC of an HTTP/2 path, "/motiondb.v1.QueryService/Recognize"; null if unknown.
const google::protobuf::MethodDescriptor* FindRpc(std::string_view path);

// Returns an upper bound for the memory of a message of this type after parsing, in bytes. It is
// many times the size of `bytes` if the message has many small parts. `bytes` need not be valid.
// O(bytes).
std::int64_t ParsedSize(const google::protobuf::Descriptor& type,
                        std::span<const std::uint8_t> bytes);

}  // namespace motiondb::server
