// Readers and writers of the formats, one pair each. Contracts: <motiondb/annotation_file.h>.
#pragma once

#include <motiondb/annotation_file.h>

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// The file to read.
struct AnnotationSource {
  std::string_view file_name;
  std::string_view bytes;
  std::string_view default_track;
};

absl::StatusOr<AnnotationFile> ReadAnnotationTsv(const AnnotationSource& source);
absl::StatusOr<std::string> WriteAnnotationTsv(const std::vector<Annotation>& annotations);

absl::StatusOr<AnnotationFile> ReadAnnotationJson(const AnnotationSource& source);
std::string WriteAnnotationJson(const std::vector<Annotation>& annotations);

absl::StatusOr<AnnotationFile> ReadBabel(const AnnotationSource& source);
std::string WriteBabel(const std::vector<AnnotatedClip>& clips,
                       const std::vector<Annotation>& annotations);

absl::StatusOr<AnnotationFile> ReadTextGrid(const AnnotationSource& source);
absl::StatusOr<std::string> WriteTextGrid(const AnnotatedClip& clip,
                                          const std::vector<Annotation>& annotations);

// Returns an error that names place and field unless label, times, confidence, track and source are
// as Annotation requires. All readers call it.
absl::Status CheckAnnotation(const Annotation& annotation);

// Returns the number that the whole text is; nullopt if it is none or not finite.
std::optional<double> ParseFiniteNumber(std::string_view text);

// Returns the last part of a path without its extension.
std::string FileStem(std::string_view path);

}  // namespace motiondb::client
