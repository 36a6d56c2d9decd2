// JSON documents with limits, and typed access to their values.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

inline constexpr int kMaxJsonDepth = 32;
inline constexpr int kMaxJsonValues = 8'000'000;

// Parses a document. INVALID_ARGUMENT with file and line: it is no JSON, or deeper than
// kMaxJsonDepth, or has more than kMaxJsonValues values.
absl::StatusOr<nlohmann::json> ParseJsonDocument(std::string_view file_name,
                                                 std::string_view bytes);

// Read a value of an object; an absent one or null leaves `value` unchanged. `place` names the
// object in errors, "FILE: PATH". INVALID_ARGUMENT: another type, or a number that is not finite.
absl::Status ReadJsonText(const nlohmann::json& object, const char* key, const std::string& place,
                          std::string& value);
absl::Status ReadJsonNumber(const nlohmann::json& object, const char* key, const std::string& place,
                            std::optional<double>& value);

// Returns INVALID_ARGUMENT: "PLACE: expected EXPECTED, found TYPE".
absl::Status JsonTypeError(const std::string& place, const char* expected,
                           const nlohmann::json& found);

}  // namespace motiondb::client
