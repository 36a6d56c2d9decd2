#include "server/translate/model_page.h"

#include <fmt/format.h>

#include <charconv>

#include "core/motion/error.h"
#include "server/translate/field_violation.h"
#include "server/translate/page.h"

namespace motiondb::server {

std::string EncodeModelPosition(std::string_view scope, const ModelPosition& position) {
  return EncodePageToken(scope, fmt::format("{}:{}", position.version, position.index));
}

absl::StatusOr<ModelPosition> DecodeModelPosition(std::string_view scope,
                                                  const std::string& token) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string text, DecodePageToken(scope, token));
  ModelPosition position;
  if (text.empty()) return position;
  const char* const end = text.data() + text.size();
  const auto version = std::from_chars(text.data(), end, position.version);
  const bool has_index = version.ec == std::errc() && version.ptr != end && *version.ptr == ':';
  const auto index = std::from_chars(has_index ? version.ptr + 1 : end, end, position.index);
  if (index.ec != std::errc() || index.ptr != end || position.index < 0) {
    return FieldViolation("page_token", "expected the next_page_token of the page before");
  }
  return position;
}

ModelId PinnedTo(const ModelPosition& position, const ModelId& id) {
  return {id.database, position.version == 0 ? id.version : 0};
}

absl::Status CheckStillCurrent(const ModelPosition& position, const storage::ModelRecord& current) {
  if (position.version == 0 || position.version == current.version) return absl::OkStatus();
  return absl::AbortedError(
      fmt::format("model {} was replaced by model {} while it was being listed: list again from "
                  "the first page",
                  position.version, current.version));
}

}  // namespace motiondb::server
