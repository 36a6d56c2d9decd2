// Files of annotations: labelled time ranges of clips, as TSV, JSON, BABEL or Praat TextGrid.
// docs/annotations.md describes the formats. The functions need no server: a caller converts an
// Annotation to a v1::Segment.
//
// Thread-safety: all functions are thread-safe. They are pure: they read and write no files.
// Errors: INVALID_ARGUMENT with file, line or JSON path, field, what was expected and found.
// Hostile input gives an error. Time and memory are proportional to the input, which has at most
// kMaxAnnotationBytes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

inline constexpr std::size_t kMaxAnnotationBytes = std::size_t{64} << 20;

// A labelled time range of a clip.
struct Annotation {
  // Name of the clip, or of its motion file, with or without folders and extension.
  std::string clip;
  // 1 to 63 of a-z, 0-9, '-', '_'.
  std::string track;
  // One line of UTF-8, not empty.
  std::string label;
  double start_seconds = 0;  // finite, not negative
  // After the start; none: the end of the clip.
  std::optional<double> end_seconds;
  // 0 to 1; none: not known.
  std::optional<double> confidence;
  // "person", "import", "suggestion", or empty: not known.
  std::string source;
  // Where it was read, for errors: "labels.tsv:12". Not written.
  std::string place;

  bool operator==(const Annotation&) const = default;
};

enum class AnnotationFormat {
  kTsv,       // clip, start, end, label, track, confidence, source
  kJson,      // an array of objects with the same names
  kBabel,     // BABEL: sequences with frame_ann or seq_ann
  kTextGrid,  // Praat: one clip per file, an interval tier for each track
};

// Returns the format of a file by its extension, .tsv, .json or .TextGrid, ignoring case; of a JSON
// file by its first character. Nullopt: another extension.
std::optional<AnnotationFormat> AnnotationFormatOf(std::string_view file_name,
                                                   std::string_view bytes);

// What was read.
struct AnnotationFile {
  std::vector<Annotation> annotations;  // in the order of the file
  std::vector<std::string> notes;       // what the file has and annotations have not; one line each
};

// Reads a file. `file_name`, with folders, is the name in errors; the clip of a TextGrid is its
// last part without extension. `default_track`: track of annotations without one; of BABEL: of all;
// of a TextGrid: of tiers without a name. BABEL labels that overlap are on the tracks
// "{default_track}-2" and so on.
absl::StatusOr<AnnotationFile> ReadAnnotations(AnnotationFormat format, std::string_view file_name,
                                               std::string_view bytes,
                                               std::string_view default_track = "action");

// The clip of annotations to write.
struct AnnotatedClip {
  std::string clip;       // as in Annotation::clip
  std::string file_name;  // of its motion; BABEL names it
  double duration_seconds = 0;
};

// Returns the bytes of a file with the annotations of `clips`, in the given order. BABEL lacks
// track, confidence and source; a TextGrid lacks confidence and source. INVALID_ARGUMENT: the
// format cannot represent an annotation (TSV: a tab in a label; TextGrid: other than one clip, or
// overlapping annotations on one track), or its clip is not one of `clips`.
absl::StatusOr<std::string> WriteAnnotations(AnnotationFormat format,
                                             const std::vector<AnnotatedClip>& clips,
                                             const std::vector<Annotation>& annotations);

}  // namespace motiondb::client
