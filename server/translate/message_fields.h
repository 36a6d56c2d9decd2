// Checks of request fields, and access to fields of messages. An error has the path of the field.
// Text that is stored is checked, because it is later shown in tables and on terminals.
#pragma once

#include <google/protobuf/message.h>
#include <google/protobuf/timestamp.pb.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/error.h"

namespace motiondb::server {

using core::AtField;
using core::FieldViolation;

// Returns INVALID_ARGUMENT unless `value` is finite and positive.
absl::Status CheckPositive(std::string_view field, double value);

// Returns INVALID_ARGUMENT if the text contains a bearer token, because many users can read stored
// text.
absl::Status CheckNoToken(std::string_view field, std::string_view text);

// Returns INVALID_ARGUMENT for more than `max_bytes` bytes, a display control
// (core/format/text_scanner.h), or a token.
absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t max_bytes);

// Like CheckPlainText, for a text file of any length, with line ends and tabs.
absl::Status CheckPlainLines(std::string_view field, std::string_view text);

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
