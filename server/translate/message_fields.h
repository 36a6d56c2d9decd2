// Access to fields of messages.
#pragma once

#include <google/protobuf/message.h>
#include <google/protobuf/timestamp.pb.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/motion/error.h"

namespace motiondb::server {

using core::AtField;
using core::FieldViolation;

// Returns the value of the string field at `path`, for example "prediction.database". Returns an
// empty string if a message on the path is absent, or for an empty path. REQUIRES: the type of the
// message has the path.
std::string FieldText(const google::protobuf::Message& message, std::string_view path);

// Returns the string field at `path` of a message type; null if it does not exist, is repeated, or
// is not a string.
const google::protobuf::FieldDescriptor* FindTextField(const google::protobuf::Descriptor& type,
                                                       std::string_view path);

static_assert(std::endian::native == std::endian::little, "packed floats are copied unchanged");

// Appends `count` packed floats.
inline void AppendPacked(const float* values, std::size_t count, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(float));
}

// Sets a Timestamp from microseconds since the Unix epoch; they may be negative.
inline void SetTimestamp(std::int64_t time_us, google::protobuf::Timestamp& timestamp) {
  const std::int64_t rest = (time_us % 1'000'000 + 1'000'000) % 1'000'000;
  timestamp.set_seconds((time_us - rest) / 1'000'000);
  timestamp.set_nanos(static_cast<std::int32_t>(rest * 1000));
}

}  // namespace motiondb::server
