// Annotations as a JSON array of objects.
#include <fmt/format.h>

#include "client/annotation/formats.h"
#include "client/annotation/json_document.h"

namespace motiondb::client {
namespace {

absl::StatusOr<Annotation> ReadObject(const nlohmann::json& object, const std::string& place,
                                      std::string_view default_track) {
  if (!object.is_object()) return JsonTypeError(place, "an object", object);
  Annotation annotation;
  annotation.place = place;
  annotation.track = default_track;
  std::optional<double> start;
  absl::Status status = ReadJsonText(object, "clip", place, annotation.clip);
  status.Update(ReadJsonText(object, "label", place, annotation.label));
  status.Update(ReadJsonText(object, "track", place, annotation.track));
  status.Update(ReadJsonText(object, "source", place, annotation.source));
  status.Update(ReadJsonNumber(object, "start", place, start));
  status.Update(ReadJsonNumber(object, "end", place, annotation.end_seconds));
  status.Update(ReadJsonNumber(object, "confidence", place, annotation.confidence));
  if (status.ok() && !start) {
    status = absl::InvalidArgumentError(place + ": start: expected a number, found nothing");
  }
  if (!status.ok()) return status;
  annotation.start_seconds = *start;
  if (status = CheckAnnotation(annotation); !status.ok()) return status;
  return annotation;
}

}  // namespace

absl::StatusOr<AnnotationFile> ReadAnnotationJson(const AnnotationSource& source) {
  const auto document = ParseJsonDocument(source.file_name, source.bytes);
  if (!document.ok()) return document.status();
  if (!document->is_array()) {
    return JsonTypeError(std::string(source.file_name), "an array of annotations", *document);
  }
  AnnotationFile file;
  for (std::size_t i = 0; i < document->size(); ++i) {
    auto annotation = ReadObject((*document)[i], fmt::format("{}: [{}]", source.file_name, i),
                                 source.default_track);
    if (!annotation.ok()) return annotation.status();
    file.annotations.push_back(*std::move(annotation));
  }
  return file;
}

std::string WriteAnnotationJson(const std::vector<Annotation>& annotations) {
  std::string text = "[";
  for (const Annotation& annotation : annotations) {
    nlohmann::ordered_json object;
    object["clip"] = annotation.clip;
    object["start"] = annotation.start_seconds;
    if (annotation.end_seconds) object["end"] = *annotation.end_seconds;
    object["label"] = annotation.label;
    object["track"] = annotation.track;
    if (annotation.confidence) object["confidence"] = *annotation.confidence;
    if (!annotation.source.empty()) object["source"] = annotation.source;
    text += text.size() == 1 ? "\n" : ",\n";
    text += object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
  return text + "\n]\n";
}

}  // namespace motiondb::client
