// Fields of a request that nothing else checks. An error names the field that was wrong. Numbers:
// NaN, infinity and what lies outside the range is INVALID_ARGUMENT. Texts: those that are stored
// and end up in tables and on terminals. Safe to call from any thread.
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

// INVALID_ARGUMENT unless `value` is finite and positive.
absl::Status CheckPositive(std::string_view field, double value);

// INVALID_ARGUMENT for what looks like a bearer token: whatever is stored has many readers.
absl::Status CheckNoToken(std::string_view field, std::string_view text);

// INVALID_ARGUMENT for more bytes than `most`, a display control (core/format/text_scanner.h), or
// a token.
absl::Status CheckPlainText(std::string_view field, std::string_view text, std::size_t most);

// The same for a text file of any length, which may have line ends and tabs.
absl::Status CheckPlainLines(std::string_view field, std::string_view text);

// The text in a field of any message. Safe to call from any thread.

// `path` is that of a string field, as "prediction.database". Empty where a message on the way is
// absent, and for the empty path. The path must be one of the message's type.
std::string FieldText(const google::protobuf::Message& message, std::string_view path);

// The field at the path in a message type; null if there is none, or it is no single string.
const google::protobuf::FieldDescriptor* FindTextField(const google::protobuf::Descriptor& type,
                                                       std::string_view path);

// Packed floats of a response. Safe to call from any thread.

static_assert(std::endian::native == std::endian::little, "packed floats are copied as they are");

// Appends `count` floats.
inline void AppendPacked(const float* values, std::size_t count, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(float));
}

// Appends one packed float.
inline void AppendPacked(float value, std::string& bytes) { AppendPacked(&value, 1, bytes); }

// Microseconds since the Unix epoch -> google.protobuf.Timestamp.

inline void SetTimestamp(std::int64_t time_us, google::protobuf::Timestamp& timestamp) {
  timestamp.set_seconds(time_us / 1'000'000);
  timestamp.set_nanos(static_cast<std::int32_t>(time_us % 1'000'000 * 1000));
}

}  // namespace motiondb::server
