#include "server/translate/annotation_request.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/edit.pb.h"
#include "motiondb/v1/segment.pb.h"
#include "server/translate/annotation_values.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxLabelBytes = 255;
constexpr std::size_t kMaxWordBytes = 63;
constexpr int kMaxChanges = 1000;

// The name of a track or the id of a segment.
absl::Status CheckSegmentWord(std::string_view field, std::string_view word) {
  const bool valid =
      !word.empty() && word.size() <= kMaxWordBytes && std::ranges::all_of(word, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
      });
  if (valid) return CheckNoToken(field, word);
  return FieldViolation(field, "expected 1 to 63 of a-z, 0-9, '-', '_', got '{}'",
                        text::SafeText(word));
}

absl::Status CheckLabel(std::string_view field, const std::string& label) {
  if (label.empty()) {
    return FieldViolation(field, "expected a label; delete the segment to remove its label");
  }
  return CheckPlainText(field, label, kMaxLabelBytes);
}

// An etag is the revision of the object. Returns 0 for the empty etag, which fits any.
absl::StatusOr<std::int64_t> ParseEtag(std::string_view field, const std::string& etag) {
  if (etag.empty()) return 0;
  std::int64_t revision = 0;
  const char* const end = etag.data() + etag.size();
  const auto [parsed, error] = std::from_chars(etag.data(), end, revision);
  if (error == std::errc() && parsed == end && revision > 0) return revision;
  return FieldViolation(field, "expected the etag of a response, got '{}'", text::SafeText(etag));
}

constexpr std::string_view kFieldPrefix = "fields.";

// Adds one path of the mask to the change.
absl::Status AddToChange(const v1::Clip& clip, const std::string& path,
                         storage::ClipChange& change) {
  if (path == "label") {
    change.label = clip.label();
    return CheckLabel("clip.label", clip.label());
  }
  if (path == "subject") {
    change.subject = clip.subject();
    return CheckPlainText("clip.subject", clip.subject(), kMaxLabelBytes);
  }
  if (path == "title") {
    change.title = clip.title();
    return CheckTitle("clip.title", clip.title());
  }
  if (path == "description") {
    change.description = clip.description();
    return CheckDescription("clip.description", clip.description());
  }
  if (path == "tags") {
    MOTIONDB_ASSIGN_OR_RETURN(change.tags, ParseTags("clip.tags", clip.tags()));
    return absl::OkStatus();
  }
  if (path == "fields") {
    MOTIONDB_ASSIGN_OR_RETURN(change.fields, ParseFields("clip.fields", clip.fields()));
    return absl::OkStatus();
  }
  if (path.starts_with(kFieldPrefix)) {
    const std::string name = path.substr(kFieldPrefix.size());
    MOTIONDB_RETURN_IF_ERROR(CheckFieldName("update_mask", name));
    std::optional<storage::FieldValue>& value = change.field[name];
    const auto given = clip.fields().find(name);
    if (given == clip.fields().end()) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(value,
                              ParseFieldValue(fmt::format("clip.fields[{}]", name), given->second));
    return absl::OkStatus();
  }
  return FieldViolation("update_mask",
                        "expected label, subject, title, description, tags, fields or "
                        "fields.NAME, got '{}'",
                        text::SafeText(path));
}

absl::Status CheckSeconds(std::string_view field, double seconds) {
  if (std::isfinite(seconds) && seconds >= 0) return absl::OkStatus();
  return FieldViolation(field, "expected seconds from 0, got {}", seconds);
}

absl::StatusOr<double> ParseConfidence(const v1::Segment& segment) {
  if (!segment.has_confidence()) return 1.0;
  const double confidence = segment.confidence();
  if (confidence >= 0 && confidence <= 1) return confidence;
  return FieldViolation("segment.confidence", "expected 0 to 1, got {}", confidence);
}

absl::StatusOr<storage::SegmentSource> ParseSource(v1::SegmentSource source) {
  switch (source) {
    case v1::SEGMENT_SOURCE_UNSPECIFIED:
    case v1::SEGMENT_SOURCE_PERSON:
      return storage::SegmentSource::kPerson;
    case v1::SEGMENT_SOURCE_IMPORT:
      return storage::SegmentSource::kImport;
    case v1::SEGMENT_SOURCE_SUGGESTION:
      return storage::SegmentSource::kSuggestion;
    default:
      return FieldViolation("segment.source",
                            "unknown source {}; expected person, import or suggestion",
                            static_cast<int>(source));
  }
}

std::optional<double> EndOf(const v1::Segment& segment) {
  return segment.has_end_seconds() ? std::optional(segment.end_seconds()) : std::nullopt;
}

absl::Status CheckRange(double start_seconds, std::optional<double> end_seconds) {
  MOTIONDB_RETURN_IF_ERROR(CheckSeconds("segment.start_seconds", start_seconds));
  if (!end_seconds) return absl::OkStatus();
  MOTIONDB_RETURN_IF_ERROR(CheckSeconds("segment.end_seconds", *end_seconds));
  if (*end_seconds > start_seconds) return absl::OkStatus();
  return FieldViolation("segment.end_seconds", "expected more than the start, {} s, got {} s",
                        start_seconds, *end_seconds);
}

absl::Status AddToChange(const v1::Segment& segment, const std::string& path,
                         storage::SegmentChange& change) {
  if (path == "label") {
    change.label = segment.label();
    return CheckLabel("segment.label", segment.label());
  }
  if (path == "start_seconds") {
    change.start_seconds = segment.start_seconds();
    return CheckSeconds("segment.start_seconds", segment.start_seconds());
  }
  if (path == "end_seconds") {
    change.end_seconds = EndOf(segment);
    return CheckSeconds("segment.end_seconds", segment.end_seconds());
  }
  if (path == "source") {
    MOTIONDB_ASSIGN_OR_RETURN(change.source, ParseSource(segment.source()));
    return absl::OkStatus();
  }
  if (path == "confidence") {
    MOTIONDB_ASSIGN_OR_RETURN(change.confidence, ParseConfidence(segment));
    return absl::OkStatus();
  }
  return FieldViolation(
      "update_mask", "expected label, start_seconds, end_seconds, source or confidence, got '{}'",
      text::SafeText(path));
}

template <typename Object, typename Change>
absl::Status AddMask(const google::protobuf::FieldMask& mask, const Object& object,
                     Change& change) {
  if (mask.paths().empty()) {
    return FieldViolation("update_mask", "expected the fields to change");
  }
  for (const std::string& path : mask.paths()) {
    MOTIONDB_RETURN_IF_ERROR(AddToChange(object, path, change));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<RequestedChange> ParseChange(const v1::UpdateClipRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("clip.name", request.clip().name()));
  storage::ClipChange change{.clip = id.id};
  MOTIONDB_ASSIGN_OR_RETURN(change.revision, ParseEtag("clip.etag", request.clip().etag()));
  MOTIONDB_RETURN_IF_ERROR(AddMask(request.update_mask(), request.clip(), change));
  return RequestedChange{id.database, std::move(change)};
}

absl::StatusOr<RequestedChange> ParseChange(const v1::CreateSegmentRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseClipName("parent", request.parent()));
  const v1::Segment& from = request.segment();
  storage::SegmentRecord segment{
      .database = id.database, .clip = id.id, .id = request.segment_id()};
  if (!segment.id.empty()) MOTIONDB_RETURN_IF_ERROR(CheckSegmentWord("segment_id", segment.id));
  if (!from.track().empty()) segment.track = from.track();
  MOTIONDB_RETURN_IF_ERROR(CheckSegmentWord("segment.track", segment.track));
  segment.label = from.label();
  MOTIONDB_RETURN_IF_ERROR(CheckLabel("segment.label", segment.label));
  segment.start_seconds = from.start_seconds();
  segment.end_seconds = EndOf(from);
  MOTIONDB_RETURN_IF_ERROR(CheckRange(segment.start_seconds, segment.end_seconds));
  MOTIONDB_ASSIGN_OR_RETURN(segment.source, ParseSource(from.source()));
  MOTIONDB_ASSIGN_OR_RETURN(segment.confidence, ParseConfidence(from));
  return RequestedChange{id.database, storage::SegmentCreation{std::move(segment)}};
}

absl::StatusOr<RequestedChange> ParseChange(const v1::UpdateSegmentRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const SegmentId id,
                            ParseSegmentName("segment.name", request.segment().name()));
  storage::SegmentChange change{.clip = id.clip, .id = id.id};
  MOTIONDB_ASSIGN_OR_RETURN(change.revision, ParseEtag("segment.etag", request.segment().etag()));
  MOTIONDB_RETURN_IF_ERROR(AddMask(request.update_mask(), request.segment(), change));
  return RequestedChange{id.database, std::move(change)};
}

absl::StatusOr<RequestedChange> ParseChange(const v1::DeleteSegmentRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const SegmentId id, ParseSegmentName("name", request.name()));
  storage::SegmentDeletion deletion{.clip = id.clip, .id = id.id};
  MOTIONDB_ASSIGN_OR_RETURN(deletion.revision, ParseEtag("etag", request.etag()));
  return RequestedChange{id.database, std::move(deletion)};
}

namespace {

// Returns the change, and the name of its field in v1::Change.
std::pair<absl::StatusOr<RequestedChange>, std::string_view> ParseOne(const v1::Change& change) {
  switch (change.change_case()) {
    case v1::Change::kUpdateClip:
      return {ParseChange(change.update_clip()), "update_clip"};
    case v1::Change::kCreateSegment:
      return {ParseChange(change.create_segment()), "create_segment"};
    case v1::Change::kUpdateSegment:
      return {ParseChange(change.update_segment()), "update_segment"};
    case v1::Change::kDeleteSegment:
      return {ParseChange(change.delete_segment()), "delete_segment"};
    case v1::Change::CHANGE_NOT_SET:
      break;
  }
  return {core::InvalidArgument(
              "expected one of update_clip, create_segment, update_segment, delete_segment"),
          "change"};
}

}  // namespace

absl::StatusOr<std::vector<storage::Change>> ParseChanges(const std::string& database,
                                                          const v1::BatchEditRequest& request) {
  if (request.changes_size() > kMaxChanges) {
    return FieldViolation("changes", "expected at most {} changes, got {}", kMaxChanges,
                          request.changes_size());
  }
  std::vector<storage::Change> changes;
  changes.reserve(static_cast<std::size_t>(request.changes_size()));
  for (int i = 0; i < request.changes_size(); ++i) {
    auto [change, field] = ParseOne(request.changes(i));
    const std::string path = fmt::format("changes[{}].{}", i, field);
    if (!change.ok()) return core::Within(path, change.status());
    if (change->database != database) {
      return FieldViolation(path, "expected an object of database '{}', got one of '{}'", database,
                            text::SafeText(change->database));
    }
    changes.push_back(std::move(change->change));
  }
  return changes;
}

}  // namespace motiondb::server
