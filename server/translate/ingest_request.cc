#include "server/translate/ingest_request.h"

#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/engine/file_names.h"
#include "server/engine/ingest_rules.h"
#include "server/translate/annotation_request.h"
#include "server/translate/file_format.h"
#include "server/translate/message_fields.h"

namespace motiondb::server {
namespace {

absl::Status ParseFileNames(const v1::IngestClipHeader& header, storage::ClipRecord& record) {
  record.file_name = WithoutFolders(header.file_name());
  record.skeleton_file_name = WithoutFolders(header.skeleton_file_name());
  if (record.file_name.empty()) return FieldViolation("header.file_name", "is missing");
  MOTIONDB_ASSIGN_OR_RETURN(record.format,
                            ParseFileFormat("header", header.format(), record.file_name));
  return absl::OkStatus();
}

absl::Status ParseAnnotations(const v1::IngestClipHeader& header, storage::ClipRecord& record) {
  record.tags.assign(header.tags().begin(), header.tags().end());
  MOTIONDB_ASSIGN_OR_RETURN(record.fields, ParseFields("header.fields", header.fields()));
  record.label = header.label();
  record.subject = header.subject();
  record.title = header.title();
  record.description = header.description();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<IngestRequest> ParseIngestHeader(const v1::IngestClipHeader& header) {
  IngestRequest request;
  storage::ClipRecord& record = request.clip.record;
  MOTIONDB_RETURN_IF_ERROR(ParseFileNames(header, record));
  MOTIONDB_RETURN_IF_ERROR(ParseAnnotations(header, record));
  MOTIONDB_ASSIGN_OR_RETURN(const Conventions conventions,
                            ParseConventions("header", header.conventions()));
  record.given = conventions.read;
  record.given_leg_length_m = conventions.leg_length_m;
  request.force = conventions.force;
  record.id = header.clip_id();
  request.clip.id_is_fixed = !header.clip_id().empty();
  request.replace = header.replace();
  request.validate_only = header.validate_only();
  return request;
}

absl::StatusOr<IngestRequest> ParseUpload(const v1::UploadClipRequest& message,
                                          std::size_t max_file_bytes) {
  MOTIONDB_ASSIGN_OR_RETURN(IngestRequest request, ParseIngestHeader(message.header()));
  MOTIONDB_RETURN_IF_ERROR(CheckNewClip(request));
  MOTIONDB_RETURN_IF_ERROR(CheckFileSize(
      request, message.file().size() + message.skeleton_file().size(), max_file_bytes));
  request.clip.file_bytes = message.file();
  request.clip.skeleton_bytes = message.skeleton_file();
  MOTIONDB_RETURN_IF_ERROR(CheckFiles(request, "file", "skeleton_file"));
  return request;
}

}  // namespace motiondb::server
