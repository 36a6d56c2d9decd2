#include "server/translate/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "absl/strings/escaping.h"
#include "core/motion/error.h"
#include "server/translate/message_fields.h"

namespace motiondb::server {

namespace {

constexpr char kSeparator = '\n';  // not in any scope

}  // namespace

absl::StatusOr<int> PageSize(std::int32_t page_size, int fallback, int max_size) {
  if (page_size < 0) return FieldViolation("page_size", "expected 0 or more, got {}", page_size);
  return page_size == 0 ? fallback : std::min<int>(page_size, max_size);
}

std::string EncodePageToken(std::string_view scope, std::string_view position) {
  return absl::WebSafeBase64Escape(fmt::format("{}{}{}", scope, kSeparator, position));
}

absl::StatusOr<std::string> DecodePageToken(std::string_view scope, const std::string& token) {
  if (token.empty()) return std::string();
  std::string decoded;
  const bool valid = absl::WebSafeBase64Unescape(token, &decoded);
  const std::string prefix = fmt::format("{}{}", scope, kSeparator);
  if (!valid || !decoded.starts_with(prefix) || decoded.size() == prefix.size()) {
    return FieldViolation("page_token",
                          "expected the next_page_token of the previous page of the same list");
  }
  return decoded.substr(prefix.size());
}

bool PageBudget::Take(std::size_t bytes) {
  if (items_left_ == 0 || (!first_ && bytes > bytes_left_)) return false;
  first_ = false;
  --items_left_;
  bytes_left_ -= std::min(bytes, bytes_left_);
  return true;
}

std::string EncodeModelPosition(std::string_view scope, const ModelPosition& position) {
  return EncodePageToken(scope, fmt::format("{}:{}:{}", position.model.version,
                                            position.model.create_time_us, position.index));
}

absl::StatusOr<ModelPosition> DecodeModelPosition(std::string_view scope,
                                                  const std::string& token) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string text, DecodePageToken(scope, token));
  ModelPosition position;
  if (text.empty()) return position;
  const char* const end = text.data() + text.size();
  // Reads a number and the following separator. Returns the position after it; null on an error.
  const auto read = [end](const char* from, auto& number, bool is_last) -> const char* {
    if (from == nullptr) return nullptr;
    const auto [after, error] = std::from_chars(from, end, number);
    if (error != std::errc() || (after == end) != is_last) return nullptr;
    if (is_last) return after;
    return *after == ':' ? after + 1 : nullptr;
  };
  const char* const time = read(text.data(), position.model.version, false);
  const char* const index = read(time, position.model.create_time_us, false);
  if (read(index, position.index, true) == nullptr || position.index < 0) {
    return FieldViolation("page_token", "expected the next_page_token of the previous page");
  }
  return position;
}

}  // namespace motiondb::server
