#include "server/translate/ingest_request.h"

#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/engine/file_names.h"
#include "server/translate/annotation_values.h"
#include "server/translate/file_format.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxTextBytes = 255;

// Checks the name of a file that other users may export. A name with a leading '.' would be hidden,
// and a name with a leading '-' would be an option in a command.
absl::Status CheckFileName(std::string_view field, std::string_view name) {
  if (name.starts_with('.') || name.starts_with('-')) {
    return FieldViolation(field, "expected a name that begins with neither '.' nor '-', got '{}'",
                          name);
  }
  return CheckPlainText(field, name, kMaxTextBytes);
}

absl::Status ParseFileNames(const v1::IngestClipHeader& header, storage::ClipRecord& record) {
  record.file_name = WithoutFolders(header.file_name());
  record.skeleton_file_name = WithoutFolders(header.skeleton_file_name());
  if (record.file_name.empty()) return FieldViolation("header.file_name", "is missing");
  MOTIONDB_RETURN_IF_ERROR(CheckFileName("header.file_name", record.file_name));
  MOTIONDB_RETURN_IF_ERROR(CheckFileName("header.skeleton_file_name", record.skeleton_file_name));
  MOTIONDB_ASSIGN_OR_RETURN(record.format,
                            ParseFileFormat("header", header.format(), record.file_name));
  return CheckSkeletonFile("header", record.format, record.skeleton_file_name);
}

absl::Status ParseAnnotations(const v1::IngestClipHeader& header, storage::ClipRecord& record) {
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText("header.label", header.label(), kMaxTextBytes));
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText("header.subject", header.subject(), kMaxTextBytes));
  MOTIONDB_RETURN_IF_ERROR(CheckTitle("header.title", header.title()));
  MOTIONDB_RETURN_IF_ERROR(CheckDescription("header.description", header.description()));
  MOTIONDB_ASSIGN_OR_RETURN(record.tags, ParseTags("header.tags", header.tags()));
  MOTIONDB_ASSIGN_OR_RETURN(record.fields, ParseFields("header.fields", header.fields()));
  record.label = header.label();
  record.subject = header.subject();
  record.title = header.title();
  record.description = header.description();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ParsedIngest> ParseIngestHeader(const v1::IngestClipHeader& header) {
  ParsedIngest parsed;
  MOTIONDB_ASSIGN_OR_RETURN(parsed.database, ParseDatabaseName("header.parent", header.parent()));
  IngestRequest& request = parsed.request;
  storage::ClipRecord& record = request.clip.record;
  MOTIONDB_RETURN_IF_ERROR(ParseFileNames(header, record));
  MOTIONDB_RETURN_IF_ERROR(ParseAnnotations(header, record));
  MOTIONDB_ASSIGN_OR_RETURN(const Conventions conventions,
                            ParseConventions("header", header.conventions()));
  record.given = conventions.read;
  record.given_leg_length_m = conventions.leg_length_m;
  request.force = conventions.force;
  if (!header.clip_id().empty()) {
    MOTIONDB_RETURN_IF_ERROR(CheckClipId("header.clip_id", header.clip_id()));
  }
  record.id = header.clip_id();
  request.clip.id_is_fixed = !header.clip_id().empty();
  request.replace = header.replace();
  request.validate_only = header.validate_only();
  return parsed;
}

absl::Status CheckFileSize(const IngestRequest& request, std::size_t more_bytes,
                           std::size_t max_file_bytes) {
  const std::size_t bytes = request.clip.file_bytes.size() + request.clip.skeleton_bytes.size();
  if (more_bytes <= max_file_bytes - bytes) return absl::OkStatus();
  return core::WithReason(
      "FILE_TOO_LARGE",
      absl::ResourceExhaustedError(
          fmt::format("{}: expected at most {} bytes, skeleton included (setting max-file-mib)",
                      request.clip.record.file_name, max_file_bytes)));
}

absl::Status CheckFiles(const IngestRequest& request, std::string_view file_field,
                        std::string_view skeleton_field) {
  const storage::ClipRecord& record = request.clip.record;
  if (request.clip.file_bytes.empty()) {
    return FieldViolation(file_field, "{}: the file is empty", record.file_name);
  }
  if (!record.skeleton_file_name.empty() && request.clip.skeleton_bytes.empty()) {
    return FieldViolation(skeleton_field, "{}: the skeleton file is empty",
                          record.skeleton_file_name);
  }
  if (record.skeleton_file_name.empty() && !request.clip.skeleton_bytes.empty()) {
    return FieldViolation(skeleton_field, "the header names no skeleton file");
  }
  return absl::OkStatus();
}

absl::StatusOr<ParsedIngest> ParseUpload(const v1::UploadClipRequest& request,
                                         std::size_t max_file_bytes) {
  MOTIONDB_ASSIGN_OR_RETURN(ParsedIngest parsed, ParseIngestHeader(request.header()));
  MOTIONDB_RETURN_IF_ERROR(CheckFileSize(
      parsed.request, request.file().size() + request.skeleton_file().size(), max_file_bytes));
  parsed.request.clip.file_bytes = request.file();
  parsed.request.clip.skeleton_bytes = request.skeleton_file();
  MOTIONDB_RETURN_IF_ERROR(CheckFiles(parsed.request, "file", "skeleton_file"));
  return parsed;
}

}  // namespace motiondb::server
