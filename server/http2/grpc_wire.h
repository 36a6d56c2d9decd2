// How gRPC writes itself into HTTP/2 headers and data ("gRPC over HTTP2"). Functions keep no state.
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/status.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace motiondb::server {

using HeaderList = std::vector<std::pair<std::string, std::string>>;

// Before each message: a byte that is 1 if it is compressed, and its length, big-endian.
inline constexpr std::size_t kMessagePrefixBytes = 5;
using MessagePrefix = std::array<std::uint8_t, kMessagePrefixBytes>;
MessagePrefix PrefixOf(std::uint32_t length);
bool IsCompressed(const MessagePrefix& prefix);
std::uint32_t LengthIn(const MessagePrefix& prefix);

// Of the header `grpc-timeout`: at most eight digits and a unit, "250m". Nothing for other text.
std::optional<std::chrono::nanoseconds> ParseTimeout(std::string_view text);

// The headers that end a call: grpc-status, grpc-message and grpc-status-details-bin.
HeaderList TrailersOf(const grpc::Status& status);

// `text` with everything but printable ASCII replaced by '?': gRPC ends the process for metadata
// that is not.
std::string PrintableAscii(std::string_view text);

// What a protobuf message takes in memory once it is read, before it is read: many times its bytes
// where it has many small parts.

// The call by its HTTP/2 path, "/motiondb.v1.QueryService/Recognize"; null for one that this
// program does not know.
const google::protobuf::MethodDescriptor* FindRpc(std::string_view path);

// Of a message of the type, which need not be valid; from above. O(bytes).
std::int64_t ParsedSize(const google::protobuf::Descriptor& type,
                        std::span<const std::uint8_t> bytes);

}  // namespace motiondb::server
