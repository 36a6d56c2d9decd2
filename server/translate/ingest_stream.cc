#include "server/translate/ingest_stream.h"

#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/engine/ingest_rules.h"
#include "server/translate/annotation_request.h"
#include "server/translate/file_format.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"

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

absl::Status IngestStream::Take(v1::IngestClipRequest message) {
  const bool is_first = database_.empty();
  if (is_first != message.has_header()) {
    return FieldViolation("header", "expected in the first message of the stream, and only there");
  }
  switch (message.part_case()) {
    case v1::IngestClipRequest::kHeader:
      return TakeHeader(message.header());
    case v1::IngestClipRequest::kFileBlock:
      return TakeBlock("file_block", *message.mutable_file_block(), request_.clip.file_bytes);
    case v1::IngestClipRequest::kSkeletonBlock:
      if (request_.clip.record.skeleton_file_name.empty()) {
        return FieldViolation("skeleton_block", "the header names no skeleton file");
      }
      return TakeBlock("skeleton_block", *message.mutable_skeleton_block(),
                       request_.clip.skeleton_bytes);
    case v1::IngestClipRequest::PART_NOT_SET:
      break;
  }
  return FieldViolation("part", "expected one of header, file_block, skeleton_block");
}

absl::Status IngestStream::TakeHeader(const v1::IngestClipHeader& header) {
  MOTIONDB_ASSIGN_OR_RETURN(std::string database,
                            ParseDatabaseName("header.parent", header.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(IngestRequest request, ParseIngestHeader(header));
  MOTIONDB_RETURN_IF_ERROR(CheckNewClip(request));
  database_ = std::move(database);
  request_ = std::move(request);
  return absl::OkStatus();
}

absl::Status IngestStream::TakeBlock(std::string_view field, std::string& block,
                                     std::string& bytes) {
  if (block.size() > kMaxBlockBytes) {
    return FieldViolation(field, "expected at most {} bytes, got {}", kMaxBlockBytes, block.size());
  }
  MOTIONDB_RETURN_IF_ERROR(CheckFileSize(request_, block.size(), max_file_bytes_));
  if (bytes.empty()) {
    bytes.swap(block);
  } else {
    bytes += block;
  }
  return absl::OkStatus();
}

absl::StatusOr<IngestRequest> IngestStream::Finish() {
  if (database_.empty()) return FieldViolation("header", "the stream ended without a header");
  MOTIONDB_RETURN_IF_ERROR(CheckFiles(request_, "file_block", "skeleton_block"));
  return std::move(request_);
}

}  // namespace motiondb::server
