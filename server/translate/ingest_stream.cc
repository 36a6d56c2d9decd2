#include "server/translate/ingest_stream.h"

#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/clip.pb.h"
#include "server/engine/file_names.h"
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

}  // namespace

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
  request_.clip.record.file_name = WithoutFolders(header.file_name());
  request_.clip.record.skeleton_file_name = WithoutFolders(header.skeleton_file_name());
  if (request_.clip.record.file_name.empty())
    return FieldViolation("header.file_name", "is missing");
  MOTIONDB_RETURN_IF_ERROR(CheckFileName("header.file_name", request_.clip.record.file_name));
  MOTIONDB_RETURN_IF_ERROR(
      CheckFileName("header.skeleton_file_name", request_.clip.record.skeleton_file_name));
  MOTIONDB_ASSIGN_OR_RETURN(
      request_.clip.record.format,
      ParseFileFormat("header", header.format(), request_.clip.record.file_name));
  MOTIONDB_RETURN_IF_ERROR(CheckSkeletonFile("header", request_.clip.record.format,
                                             request_.clip.record.skeleton_file_name));
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText("header.label", header.label(), kMaxTextBytes));
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText("header.subject", header.subject(), kMaxTextBytes));
  MOTIONDB_ASSIGN_OR_RETURN(const Conventions conventions,
                            ParseConventions("header", header.conventions()));
  if (!header.clip_id().empty()) {
    MOTIONDB_RETURN_IF_ERROR(CheckClipId("header.clip_id", header.clip_id()));
  }
  request_.clip.record.label = header.label();
  request_.clip.record.subject = header.subject();
  request_.clip.record.given = conventions.read;
  request_.clip.record.given_leg_length_m = conventions.leg_length_m;
  request_.force = conventions.force;
  request_.replace = header.replace();
  request_.validate_only = header.validate_only();
  request_.clip.record.id = header.clip_id();
  request_.clip.id_is_fixed = !header.clip_id().empty();
  database_ = std::move(database);
  return absl::OkStatus();
}

absl::Status IngestStream::TakeBlock(std::string_view field, std::string& block,
                                     std::string& bytes) {
  if (block.size() > kMaxBlockBytes) {
    return FieldViolation(field, "expected at most {} bytes, got {}", kMaxBlockBytes, block.size());
  }
  const std::size_t received =
      request_.clip.file_bytes.size() + request_.clip.skeleton_bytes.size();
  if (block.size() > max_file_bytes_ - received) {
    return core::WithReason(
        "FILE_TOO_LARGE",
        absl::ResourceExhaustedError(
            fmt::format("{}: expected at most {} bytes, skeleton included (setting max-file-mib)",
                        request_.clip.record.file_name, max_file_bytes_)));
  }
  if (bytes.empty()) {
    bytes.swap(block);
  } else {
    bytes += block;
  }
  return absl::OkStatus();
}

absl::StatusOr<IngestRequest> IngestStream::Finish() {
  if (database_.empty()) return FieldViolation("header", "the stream ended without a header");
  if (request_.clip.file_bytes.empty()) {
    return FieldViolation("file_block", "{}: the file is empty", request_.clip.record.file_name);
  }
  if (!request_.clip.record.skeleton_file_name.empty() && request_.clip.skeleton_bytes.empty()) {
    return FieldViolation("skeleton_block", "{}: the skeleton file is empty",
                          request_.clip.record.skeleton_file_name);
  }
  return std::move(request_);
}

}  // namespace motiondb::server
