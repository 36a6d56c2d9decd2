#include "tests/fuzz/client/annotation_properties.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/fuzz/support/memory_watch.h"
#include "tests/fuzz/support/properties.h"

namespace motiondb::tests {
namespace {

using client::Annotation;
using client::AnnotationFormat;

// Returns what a file of the format has of the annotations.
std::vector<Annotation> Stored(AnnotationFormat format, std::vector<Annotation> annotations) {
  for (Annotation& annotation : annotations) {
    annotation.place.clear();
    if (format == AnnotationFormat::kTextGrid) annotation.confidence.reset();
  }
  if (format == AnnotationFormat::kTextGrid) {
    std::ranges::stable_sort(annotations, {}, &Annotation::track);  // tiers in order of track
  }
  return annotations;
}

void CheckValid(const Annotation& annotation) {
  CheckContract(!annotation.clip.empty() && !annotation.label.empty(), "clip and label");
  CheckContract(std::isfinite(annotation.start_seconds) && annotation.start_seconds >= 0, "start");
  if (const auto& end = annotation.end_seconds) {
    CheckContract(std::isfinite(*end) && *end > annotation.start_seconds, "end after start");
  }
}

}  // namespace

void CheckAnnotationReader(AnnotationFormat format, const std::uint8_t* data, std::size_t size) {
  const std::string name = "input.x";
  client::AnnotationFile file;
  {
    const MemoryWatch watch;
    auto read = client::ReadAnnotations(format, name, AsText(data, size));
    watch.CheckProportional(size, 1 << 20, 400);
    if (!read.ok()) {
      CheckErrorContract(read.status(), absl::StatusCode::kInvalidArgument);
      return;
    }
    file = *std::move(read);
  }
  std::map<std::string, client::AnnotatedClip> clips;
  for (const Annotation& annotation : file.annotations) {
    CheckValid(annotation);
    client::AnnotatedClip& clip = clips[annotation.clip];
    clip.clip = clip.file_name = annotation.clip;
    clip.duration_seconds =
        std::max({clip.duration_seconds, annotation.end_seconds.value_or(0), 1.0});
  }
  if (clips.empty() || format == AnnotationFormat::kBabel) return;
  std::vector<client::AnnotatedClip> written_clips;
  for (const auto& [clip, written] : clips) written_clips.push_back(written);
  const auto bytes = client::WriteAnnotations(format, written_clips, file.annotations);
  if (!bytes.ok()) return;  // for example a comment sign at the beginning of a clip's name
  const auto again = client::ReadAnnotations(format, name, *bytes);
  CheckContract(again.ok(), "a written file can be read");
  CheckContract(Stored(format, again->annotations) == Stored(format, file.annotations),
                "a written file has the same annotations");
}

}  // namespace motiondb::tests
