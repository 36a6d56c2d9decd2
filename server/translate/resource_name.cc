#include "server/translate/resource_name.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/request_checks.h"
#include "server/translate/message_fields.h"

namespace motiondb::server {
namespace {

// Returns the ids in a name of the form `pattern`, in which each "{...}" is an id; empty if the
// name has another form.
std::vector<std::string> MatchIds(std::string_view pattern, std::string_view name) {
  std::vector<std::string> ids;
  while (true) {
    const std::string_view expected = pattern.substr(0, pattern.find('/'));
    const std::string_view segment = name.substr(0, name.find('/'));
    if (expected.front() == '{') {
      if (segment.empty()) return {};
      ids.emplace_back(segment);
    } else if (segment != expected) {
      return {};
    }
    const bool last = expected.size() == pattern.size();
    if (last != (segment.size() == name.size())) return {};
    if (last) return ids;
    pattern.remove_prefix(expected.size() + 1);
    name.remove_prefix(segment.size() + 1);
  }
}

absl::StatusOr<std::vector<std::string>> ParseIds(std::string_view field, std::string_view pattern,
                                                  std::string_view name) {
  std::vector<std::string> ids = MatchIds(pattern, name);
  if (ids.empty()) return FieldViolation(field, "expected {}, got '{}'", pattern, name);
  return ids;
}

absl::StatusOr<MemberId> ParseMember(std::string_view field, std::string_view pattern,
                                     std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<std::string> ids, ParseIds(field, pattern, name));
  return MemberId{ids[0], ids[1]};
}

// Parses a number from 1; `expected`: for the error.
template <typename Number>
absl::StatusOr<Number> ParseNumber(std::string_view field, std::string_view expected,
                                   const std::string& text) {
  const char* const end = text.data() + text.size();
  Number number = 0;
  const auto [parsed, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc() && parsed == end && number >= 1) return number;
  return FieldViolation(field, "expected {}, got '{}'", expected, text);
}

bool IsLowerOrDigit(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

}  // namespace

absl::StatusOr<std::string> ParseDatabaseName(std::string_view field, std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto ids, ParseIds(field, "databases/{database}", name));
  return ids[0];
}

absl::StatusOr<MemberId> ParseClipName(std::string_view field, std::string_view name) {
  return ParseMember(field, "databases/{database}/clips/{clip}", name);
}

absl::StatusOr<SegmentId> ParseSegmentName(std::string_view field, std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto ids,
      ParseIds(field, "databases/{database}/clips/{clip}/segments/{segment}", name));
  return SegmentId{ids[0], ids[1], ids[2]};
}

absl::StatusOr<EditId> ParseEditName(std::string_view field, std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto ids,
                            ParseIds(field, "databases/{database}/edits/{edit}", name));
  MOTIONDB_ASSIGN_OR_RETURN(const auto id,
                            ParseNumber<std::int64_t>(field, "a number from 1", ids[1]));
  return EditId{ids[0], id};
}

absl::StatusOr<MemberId> ParseSkeletonName(std::string_view field, std::string_view name) {
  return ParseMember(field, "databases/{database}/skeletons/{skeleton}", name);
}

absl::StatusOr<MemberId> ParseStreamName(std::string_view field, std::string_view name) {
  return ParseMember(field, "databases/{database}/streams/{stream}", name);
}

absl::StatusOr<ModelId> ParseModelName(std::string_view field, std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto ids,
                            ParseIds(field, "databases/{database}/models/{version}", name));
  if (ids[1] == "current") return ModelId{ids[0], 0};
  MOTIONDB_ASSIGN_OR_RETURN(const int version,
                            ParseNumber<int>(field, "a version from 1, or 'current'", ids[1]));
  return ModelId{ids[0], version};
}

absl::StatusOr<std::string> ParseOperationName(std::string_view field, std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto ids, ParseIds(field, "operations/{operation}", name));
  return ids[0];
}

absl::StatusOr<std::string> ParseTokenName(std::string_view field, std::string_view name) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto ids, ParseIds(field, "tokens/{token}", name));
  return ids[0];
}

absl::StatusOr<std::string> IdIn(const std::string& database, std::string_view field,
                                 std::string_view what, const std::string& name,
                                 const absl::StatusOr<MemberId>& parsed) {
  if (!parsed.ok()) return parsed.status();
  if (parsed->database == database) return parsed->id;
  return FieldViolation(field, "expected a {} of databases/{}, got '{}'", what, database, name);
}

absl::StatusOr<std::string> ParseClipIn(const std::string& database, const std::string& name) {
  if (name.empty()) return std::string();
  return IdIn(database, "clip", "clip", name, ParseClipName("clip", name));
}

std::string DatabaseName(std::string_view database) {
  return fmt::format("databases/{}", database);
}

std::string ClipName(std::string_view database, std::string_view clip) {
  return fmt::format("databases/{}/clips/{}", database, clip);
}

std::string SegmentName(std::string_view database, std::string_view clip,
                        std::string_view segment) {
  return fmt::format("databases/{}/clips/{}/segments/{}", database, clip, segment);
}

std::string EditName(std::string_view database, std::int64_t edit) {
  return fmt::format("databases/{}/edits/{}", database, edit);
}

std::string SkeletonName(std::string_view database, std::string_view skeleton) {
  return fmt::format("databases/{}/skeletons/{}", database, skeleton);
}

std::string StreamName(std::string_view database, std::string_view stream) {
  return fmt::format("databases/{}/streams/{}", database, stream);
}

std::string ModelName(std::string_view database, int version) {
  return fmt::format("databases/{}/models/{}", database, version);
}

std::string CurrentModelName(std::string_view database) {
  return fmt::format("databases/{}/models/current", database);
}

std::string OperationName(std::string_view operation) {
  return fmt::format("operations/{}", operation);
}

std::string TokenName(std::string_view token) { return fmt::format("tokens/{}", token); }

absl::Status CheckDatabaseId(std::string_view field, std::string_view id) {
  const bool valid =
      !id.empty() && id.size() <= 63 && IsLowerOrDigit(id.front()) &&
      std::ranges::all_of(id, [](char c) { return IsLowerOrDigit(c) || c == '-' || c == '_'; });
  if (valid) return CheckNoToken(field, id);
  return FieldViolation(
      field, "expected 1 to 63 of a-z, 0-9, '-', '_', beginning with a letter or digit, got '{}'",
      id);
}

}  // namespace motiondb::server
