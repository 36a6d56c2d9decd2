#include "client/annotation/json_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace motiondb::client {
namespace {

std::ptrdiff_t LineAt(std::string_view bytes, std::size_t offset) {
  const auto begin = bytes.begin();
  return 1 + std::count(begin, begin + static_cast<std::ptrdiff_t>(std::min(offset, bytes.size())),
                        '\n');
}

// Checks depth and number of values before the parser takes memory for them. Text that is not JSON
// is left to the parser.
absl::Status CheckJsonSize(std::string_view file_name, std::string_view bytes) {
  int depth = 0, values = 0;
  bool is_in_string = false;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char c = bytes[i];
    if (is_in_string) {
      if (c == '\\') ++i;
      is_in_string = c != '"';
      continue;
    }
    is_in_string = c == '"';
    if (c == ']' || c == '}') --depth;
    if (c == '[' || c == '{') ++depth;
    if (c == '[' || c == '{' || c == ',') ++values;
    if (depth > kMaxJsonDepth || values > kMaxJsonValues) {
      return absl::InvalidArgumentError(
          fmt::format("{}:{}: expected at most {} levels and {} values", file_name,
                      LineAt(bytes, i), kMaxJsonDepth, kMaxJsonValues));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<nlohmann::json> ParseJsonDocument(std::string_view file_name,
                                                 std::string_view bytes) {
  if (absl::Status status = CheckJsonSize(file_name, bytes); !status.ok()) return status;
  try {
    return nlohmann::json::parse(bytes);
  } catch (const nlohmann::json::parse_error& error) {
    return absl::InvalidArgumentError(
        fmt::format("{}:{}: expected JSON, found an error at byte {} of the file", file_name,
                    LineAt(bytes, error.byte), error.byte));
  } catch (const nlohmann::json::exception&) {
    return absl::InvalidArgumentError(
        fmt::format("{}: expected JSON, found a number that is too large", file_name));
  }
}

absl::Status JsonTypeError(const std::string& place, const char* expected,
                           const nlohmann::json& found) {
  return absl::InvalidArgumentError(
      fmt::format("{}: expected {}, found {}", place, expected, found.type_name()));
}

absl::Status ReadJsonText(const nlohmann::json& object, const char* key, const std::string& place,
                          std::string& value) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return absl::OkStatus();
  if (!found->is_string()) {
    return JsonTypeError(fmt::format("{}: {}", place, key), "text", *found);
  }
  value = found->get_ref<const std::string&>();
  return absl::OkStatus();
}

absl::Status ReadJsonNumber(const nlohmann::json& object, const char* key, const std::string& place,
                            std::optional<double>& value) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return absl::OkStatus();
  if (!found->is_number() || !std::isfinite(found->get<double>())) {
    return JsonTypeError(fmt::format("{}: {}", place, key), "a finite number", *found);
  }
  value = found->get<double>();
  return absl::OkStatus();
}

}  // namespace motiondb::client
