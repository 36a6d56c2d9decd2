#include "server/translate/page.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "core/motion/error.h"
#include "server/translate/field_violation.h"

namespace motiondb::server {
namespace {

constexpr char kSeparator = '\n';  // in no scope

}  // namespace

absl::StatusOr<int> PageSize(std::int32_t page_size, int fallback, int most) {
  if (page_size < 0) return FieldViolation("page_size", "must not be negative, got {}", page_size);
  return page_size == 0 ? fallback : std::min<int>(page_size, most);
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
                          "expected the next_page_token of the page before, of the same list");
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

}  // namespace motiondb::server
