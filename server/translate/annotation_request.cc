#include "server/translate/annotation_request.h"

#include <charconv>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/edit.pb.h"
#include "motiondb/v1/segment.pb.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

// An etag is the revision of the object. Returns 0 for the empty etag, which fits any.
absl::StatusOr<std::int64_t> ParseEtag(std::string_view field, const std::string& etag) {
  if (etag.empty()) return 0;
  std::int64_t revision = 0;
  const char* const end = etag.data() + etag.size();
  const auto [parsed, error] = std::from_chars(etag.data(), end, revision);
  if (error == std::errc() && parsed == end && revision > 0) return revision;
  return FieldViolation(field, "expected the etag of a response, got '{}'", text::SafeText(etag));
}

absl::StatusOr<storage::FieldValue> ParseFieldValue(std::string_view field,
                                                    const v1::FieldValue& value) {
  switch (value.value_case()) {
    case v1::FieldValue::kText:
      return storage::FieldValue(value.text());
    case v1::FieldValue::kNumber:
      return storage::FieldValue(value.number());
    case v1::FieldValue::kFlag:
      return storage::FieldValue(value.flag());
    case v1::FieldValue::kTime: {
      constexpr std::int64_t kFirst = -62'135'596'800;  // of google.protobuf.Timestamp
      constexpr std::int64_t kLast = 253'402'300'799;
      const auto& time = value.time();
      if (time.seconds() < kFirst || time.seconds() > kLast || time.nanos() < 0 ||
          time.nanos() > 999'999'999) {
        return FieldViolation(field, "expected a time of the years 1 to 9999");
      }
      return storage::FieldValue(
          storage::FieldTime{time.seconds() * 1'000'000 + time.nanos() / 1000});
    }
    case v1::FieldValue::VALUE_NOT_SET:
      break;
  }
  return FieldViolation(field, "expected one of text, number, flag, time");
}

constexpr std::string_view kFieldPrefix = "fields.";

// Adds one path of the mask to the change.
absl::Status AddToChange(const v1::Clip& clip, const std::string& path,
                         storage::ClipChange& change) {
  if (path == "label") {
    change.label = clip.label();
    return absl::OkStatus();
  }
  if (path == "subject") {
    change.subject = clip.subject();
    return absl::OkStatus();
  }
  if (path == "title") {
    change.title = clip.title();
    return absl::OkStatus();
  }
  if (path == "description") {
    change.description = clip.description();
    return absl::OkStatus();
  }
  if (path == "tags") {
    change.tags.emplace(clip.tags().begin(), clip.tags().end());
    return absl::OkStatus();
  }
  if (path == "fields") {
    MOTIONDB_ASSIGN_OR_RETURN(change.fields, ParseFields("clip.fields", clip.fields()));
    return absl::OkStatus();
  }
  if (path.starts_with(kFieldPrefix)) {
    const std::string name = path.substr(kFieldPrefix.size());
    std::optional<storage::FieldValue>& value = change.field[name];
    const auto given = clip.fields().find(name);
    if (given == clip.fields().end()) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(
        value,
        ParseFieldValue(fmt::format("clip.fields[{}]", text::SafeText(name)), given->second));
    return absl::OkStatus();
  }
  return FieldViolation("update_mask",
                        "expected label, subject, title, description, tags, fields or "
                        "fields.NAME, got '{}'",
                        text::SafeText(path));
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

double ConfidenceOf(const v1::Segment& segment) {
  return segment.has_confidence() ? segment.confidence() : 1.0;
}

std::optional<double> EndOf(const v1::Segment& segment) {
  return segment.has_end_seconds() ? std::optional(segment.end_seconds()) : std::nullopt;
}

absl::Status AddToChange(const v1::Segment& segment, const std::string& path,
                         storage::SegmentChange& change) {
  if (path == "label") {
    change.label = segment.label();
    return absl::OkStatus();
  }
  if (path == "start_seconds") {
    change.start_seconds = segment.start_seconds();
    return absl::OkStatus();
  }
  if (path == "end_seconds") {
    change.end_seconds = EndOf(segment);
    return absl::OkStatus();
  }
  if (path == "source") {
    MOTIONDB_ASSIGN_OR_RETURN(change.source, ParseSource(segment.source()));
    return absl::OkStatus();
  }
  if (path == "confidence") {
    change.confidence = ConfidenceOf(segment);
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

absl::StatusOr<storage::Fields> ParseFields(std::string_view field, const GivenFields& given) {
  storage::Fields fields;
  for (const auto& [name, value] : given) {
    const std::string path = fmt::format("{}[{}]", field, text::SafeText(name));
    MOTIONDB_ASSIGN_OR_RETURN(fields[name], ParseFieldValue(path, value));
  }
  return fields;
}

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
  if (!from.track().empty()) segment.track = from.track();
  segment.label = from.label();
  segment.start_seconds = from.start_seconds();
  segment.end_seconds = EndOf(from);
  MOTIONDB_ASSIGN_OR_RETURN(segment.source, ParseSource(from.source()));
  segment.confidence = ConfidenceOf(from);
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
