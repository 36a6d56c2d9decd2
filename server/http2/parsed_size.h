// What a protobuf message takes in memory once it is read, before it is read: many times its bytes
// where it has many small parts.
#pragma once

#include <google/protobuf/descriptor.h>

#include <cstdint>
#include <span>
#include <string_view>

namespace motiondb::server {

// The call by its HTTP/2 path, "/motiondb.v1.QueryService/Recognize"; null for one that this
// program does not know.
const google::protobuf::MethodDescriptor* FindRpc(std::string_view path);

// Of a message of the type, which need not be valid; from above. O(bytes).
std::int64_t ParsedSize(const google::protobuf::Descriptor& type,
                        std::span<const std::uint8_t> bytes);

}  // namespace motiondb::server
