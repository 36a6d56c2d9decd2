#include <fmt/format.h>
#include <motiondb/annotation_file.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "absl/strings/match.h"
#include "client/annotation/formats.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::client {
namespace {

constexpr std::size_t kMaxTrackBytes = 63;

bool IsTrack(std::string_view track) {
  return !track.empty() && track.size() <= kMaxTrackBytes &&
         track.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_") ==
             std::string_view::npos;
}

bool IsSource(std::string_view source) {
  return source.empty() || source == "person" || source == "import" || source == "suggestion";
}

absl::Status FieldError(const Annotation& annotation, const char* field, const std::string& what) {
  return absl::InvalidArgumentError(fmt::format("{}: {}: {}", annotation.place, field, what));
}

}  // namespace

absl::Status CheckAnnotation(const Annotation& annotation) {
  const auto error = [&](const char* field, const std::string& what) {
    return FieldError(annotation, field, what);
  };
  if (!text::IsUtf8(annotation.clip)) return error("clip", "expected UTF-8 text");
  if (!text::IsUtf8(annotation.label)) return error("label", "expected UTF-8 text");
  if (annotation.clip.empty()) return error("clip", "expected a clip, found nothing");
  if (annotation.label.empty()) return error("label", "expected a label, found nothing");
  if (text::FindDisplayControl(annotation.label).bytes > 0) {
    return error("label", "expected one line without control characters");
  }
  if (!(std::isfinite(annotation.start_seconds) && annotation.start_seconds >= 0)) {
    return error("start",
                 fmt::format("expected seconds, at least 0, found {}", annotation.start_seconds));
  }
  if (const auto& end = annotation.end_seconds;
      end && !(std::isfinite(*end) && *end > annotation.start_seconds)) {
    return error("end", fmt::format("expected seconds after the start, {}, found {}",
                                    annotation.start_seconds, *end));
  }
  if (const auto& confidence = annotation.confidence;
      confidence && !(*confidence >= 0 && *confidence <= 1)) {
    return error("confidence", fmt::format("expected 0 to 1, found {}", *confidence));
  }
  if (!IsTrack(annotation.track)) {
    return error("track", fmt::format("expected 1 to {} of a-z, 0-9, '-', '_', found '{}'",
                                      kMaxTrackBytes, text::SafeText(annotation.track)));
  }
  if (!IsSource(annotation.source)) {
    return error("source", fmt::format("expected person, import or suggestion, found '{}'",
                                       text::SafeText(annotation.source)));
  }
  return absl::OkStatus();
}

std::optional<double> ParseFiniteNumber(std::string_view text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::string FileStem(std::string_view path) {
  const std::string_view name = path.substr(path.find_last_of("/\\") + 1);
  const std::size_t dot = name.rfind('.');
  return std::string(dot == 0 ? name : name.substr(0, dot));
}

std::optional<AnnotationFormat> AnnotationFormatOf(std::string_view file_name,
                                                   std::string_view bytes) {
  const std::string name(file_name);
  if (absl::EndsWithIgnoreCase(name, ".tsv")) return AnnotationFormat::kTsv;
  if (absl::EndsWithIgnoreCase(name, ".textgrid")) return AnnotationFormat::kTextGrid;
  if (!absl::EndsWithIgnoreCase(name, ".json")) return std::nullopt;
  const std::size_t first = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool is_object = first != std::string_view::npos && bytes[first] == '{';
  return is_object ? AnnotationFormat::kBabel : AnnotationFormat::kJson;
}

absl::StatusOr<AnnotationFile> ReadAnnotations(AnnotationFormat format, std::string_view file_name,
                                               std::string_view bytes,
                                               std::string_view default_track) {
  if (bytes.size() > kMaxAnnotationBytes) {
    return absl::InvalidArgumentError(fmt::format("{}: expected at most {} MiB, found {} bytes",
                                                  file_name, kMaxAnnotationBytes >> 20,
                                                  bytes.size()));
  }
  const AnnotationSource source{file_name, bytes, default_track};
  switch (format) {
    case AnnotationFormat::kTsv:
      return ReadAnnotationTsv(source);
    case AnnotationFormat::kJson:
      return ReadAnnotationJson(source);
    case AnnotationFormat::kBabel:
      return ReadBabel(source);
    case AnnotationFormat::kTextGrid:
      return ReadTextGrid(source);
  }
  return absl::InvalidArgumentError("unknown format of annotations");
}

absl::StatusOr<std::string> WriteAnnotations(AnnotationFormat format,
                                             const std::vector<AnnotatedClip>& clips,
                                             const std::vector<Annotation>& annotations) {
  std::set<std::string_view> known;
  for (const AnnotatedClip& clip : clips) known.insert(clip.clip);
  for (const Annotation& annotation : annotations) {
    if (known.contains(annotation.clip)) continue;
    return absl::InvalidArgumentError(
        fmt::format("an annotation is of clip '{}', which is not written", annotation.clip));
  }
  switch (format) {
    case AnnotationFormat::kTsv:
      return WriteAnnotationTsv(annotations);
    case AnnotationFormat::kJson:
      return WriteAnnotationJson(annotations);
    case AnnotationFormat::kBabel:
      return WriteBabel(clips, annotations);
    case AnnotationFormat::kTextGrid:
      break;
  }
  if (clips.size() != 1) {
    return absl::InvalidArgumentError(
        fmt::format("a TextGrid has one clip, not {}; write a file for each clip", clips.size()));
  }
  return WriteTextGrid(clips.front(), annotations);
}

}  // namespace motiondb::client
