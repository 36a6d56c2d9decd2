#include "server/engine/ingest_rules.h"

#include <algorithm>
#include <string>

#include "core/motion/error.h"
#include "server/engine/annotation_rules.h"
#include "server/engine/request_checks.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxFileNameBytes = 255;

// Checks the name of a file that other users may export. A name with a leading '.' would be hidden,
// and a name with a leading '-' would be an option in a command.
absl::Status CheckFileName(std::string_view field, std::string_view name) {
  if (name.starts_with('.') || name.starts_with('-')) {
    return core::FieldViolation(
        field, "expected a name that begins with neither '.' nor '-', got '{}'", name);
  }
  return CheckPlainText(field, name, kMaxFileNameBytes);
}

bool IsClipIdCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || c == '-' ||
         c == '_' || c == '.';
}

}  // namespace

absl::Status CheckClipId(std::string_view field, std::string_view id) {
  if (!id.empty() && id.size() <= 127 && std::ranges::all_of(id, IsClipIdCharacter)) {
    return CheckNoToken(field, id);
  }
  return core::FieldViolation(field,
                              "expected 1 to 127 of letters, digits, '-', '_', '.', got '{}'", id);
}

absl::Status CheckNewClip(IngestRequest& request) {
  storage::ClipRecord& record = request.clip.record;
  MOTIONDB_RETURN_IF_ERROR(CheckFileName("header.file_name", record.file_name));
  MOTIONDB_RETURN_IF_ERROR(CheckFileName("header.skeleton_file_name", record.skeleton_file_name));
  MOTIONDB_RETURN_IF_ERROR(CheckSkeletonFile("header", record.format, record.skeleton_file_name));
  MOTIONDB_RETURN_IF_ERROR(CheckAnnotations("header", record));
  MOTIONDB_RETURN_IF_ERROR(
      CheckConventions("header", record.given, record.given_leg_length_m, request.force));
  return request.clip.id_is_fixed ? CheckClipId("header.clip_id", record.id) : absl::OkStatus();
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
    return core::FieldViolation(file_field, "{}: the file is empty", record.file_name);
  }
  if (!record.skeleton_file_name.empty() && request.clip.skeleton_bytes.empty()) {
    return core::FieldViolation(skeleton_field, "{}: the skeleton file is empty",
                                record.skeleton_file_name);
  }
  if (record.skeleton_file_name.empty() && !request.clip.skeleton_bytes.empty()) {
    return core::FieldViolation(skeleton_field, "the header names no skeleton file");
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
