#include "server/engine/ingest_rules.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/motion/error.h"
#include "server/engine/request_checks.h"
#include "text/utf8.h"

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

namespace {

constexpr std::size_t kMaxIdLength = 120;

// The letters of U+00C0 to U+017F (Latin-1 Supplement and Latin Extended-A) without accents.
constexpr char32_t kFirstAccented = 0xC0;
constexpr std::string_view kWithoutAccents =
    "AAAAAAACEEEEIIIIDNOOOOOxOUUUUYTsaaaaaaaceeeeiiiidnooooo_ouuuuyty"
    "AaAaAaCcCcCcCcDdDdEeEeEeEeEeGgGgGgGgHhHhIiIiIiIiIiIiJjKkkLlLlLlLlLlNnNnNnnNnOoOoOoOo"
    "RrRrRrSsSsSsSsTtTtTtUuUuUuUuUuUuWwYyYZzZzZzs";
static_assert(kWithoutAccents.size() == 0x180 - kFirstAccented);

// Returns what stands for a character in an id.
std::string InId(text::Character character) {
  constexpr char32_t kEndOfAscii = 0x80;
  const char32_t code = character.code;
  if (character.bytes == 0) return "_";
  if (code < kEndOfAscii) {
    const auto c = static_cast<char>(code);
    return {IsClipIdCharacter(c) ? c : '_'};
  }
  if (code >= kFirstAccented && code - kFirstAccented < kWithoutAccents.size()) {
    return {kWithoutAccents[code - kFirstAccented]};
  }
  const bool is_combining = code >= 0x300 && code <= 0x36F;
  return is_combining ? "" : fmt::format("u{:04x}", static_cast<std::uint32_t>(code));
}

}  // namespace

std::string WithoutFolders(std::string_view path) {
  const std::size_t slash = path.find_last_of("/\\");
  return std::string(slash == path.npos ? path : path.substr(slash + 1));
}

std::string ClipIdFromFileName(std::string_view file_name, std::string_view take) {
  for (const std::string_view gzip : {".gz", ".GZ"}) {
    if (file_name.ends_with(gzip)) file_name.remove_suffix(gzip.size());
  }
  std::string name(file_name.substr(0, file_name.rfind('.')));
  if (!take.empty()) name.append("-").append(take);
  std::string id;
  for (std::string_view rest = name; !rest.empty();) {
    const text::Character character = text::FirstCharacter(rest);
    const std::string part = InId(character);
    if (id.size() + part.size() > kMaxIdLength) break;
    id += part;
    rest.remove_prefix(std::max<std::size_t>(1, character.bytes));
  }
  return id.empty() ? "clip" : id;
}

}  // namespace motiondb::server
