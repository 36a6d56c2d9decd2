// gRPC's wire format in HTTP/2 headers and data ("gRPC over HTTP2").
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http2/message_prefix.h"

namespace motiondb::server {

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
