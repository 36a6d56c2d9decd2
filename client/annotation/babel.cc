// The layout of BABEL (babel.is.tue.mpg.de): an object of sequences, each with the labels of time
// ranges (frame_ann) or of the whole sequence (seq_ann).
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "client/annotation/formats.h"
#include "client/annotation/json_document.h"

namespace motiondb::client {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxTracks = 64;

// What the notes report.
struct BabelCounts {
  int without_duration = 0;
  int other_annotators = 0;
};

// Appends an annotation for each category of a label; without a category, for its own text.
absl::Status AddLabel(const json& label, const std::string& place, const std::string& clip,
                      bool has_times, BabelCounts& counts, std::vector<Annotation>& annotations) {
  if (!label.is_object()) return JsonTypeError(place, "an object", label);
  Annotation annotation;
  annotation.place = place;
  annotation.clip = clip;
  std::optional<double> start;
  absl::Status status = ReadJsonText(label, "proc_label", place, annotation.label);
  if (annotation.label.empty()) {
    status.Update(ReadJsonText(label, "raw_label", place, annotation.label));
  }
  if (has_times) {
    status.Update(ReadJsonNumber(label, "start_t", place, start));
    status.Update(ReadJsonNumber(label, "end_t", place, annotation.end_seconds));
    if (status.ok() && !(start && annotation.end_seconds)) {
      status = absl::InvalidArgumentError(place + ": expected start_t and end_t");
    }
  }
  if (!status.ok()) return status;
  annotation.start_seconds = start.value_or(0);
  if (has_times && *annotation.end_seconds <= annotation.start_seconds) {
    ++counts.without_duration;
    return absl::OkStatus();
  }
  const auto categories = label.find("act_cat");
  if (categories == label.end() || categories->is_null() || categories->empty()) {
    annotations.push_back(std::move(annotation));
    return absl::OkStatus();
  }
  if (!categories->is_array()) return JsonTypeError(place + ": act_cat", "an array", *categories);
  for (const json& category : *categories) {
    if (!category.is_string()) return JsonTypeError(place + ": act_cat", "texts", category);
    annotation.label = category.get<std::string>();
    annotations.push_back(annotation);
  }
  return absl::OkStatus();
}

// Puts annotations that overlap on different tracks, the earlier one on the first free track.
absl::Status AssignTracks(std::string_view track, std::vector<Annotation>& annotations) {
  std::ranges::stable_sort(annotations, {}, &Annotation::start_seconds);
  // End of the last annotation on each track; none: the end of the clip.
  std::vector<std::optional<double>> ends;
  for (Annotation& annotation : annotations) {
    const auto is_free = [&](const std::optional<double>& end) {
      return end && *end <= annotation.start_seconds;
    };
    const auto found = std::ranges::find_if(ends, is_free);
    const auto index = static_cast<std::size_t>(found - ends.begin());
    if (index == kMaxTracks) {
      return absl::InvalidArgumentError(fmt::format(
          "{}: expected at most {} labels at the same time", annotation.place, kMaxTracks));
    }
    if (index == ends.size()) ends.emplace_back();
    ends[index] = annotation.end_seconds;
    annotation.track = index == 0 ? track : fmt::format("{}-{}", track, index + 1);
    if (absl::Status status = CheckAnnotation(annotation); !status.ok()) return status;
  }
  return absl::OkStatus();
}

// Returns the annotation `one`, or the first of the array `many`, as in BABEL's extra files; null
// if there is neither.
const json* FindAnnotator(const json& sequence, const char* one, const char* many,
                          BabelCounts& counts) {
  if (const auto found = sequence.find(one); found != sequence.end() && !found->is_null()) {
    return &*found;
  }
  const auto found = sequence.find(many);
  if (found == sequence.end() || !found->is_array() || found->empty()) return nullptr;
  counts.other_annotators += static_cast<int>(found->size()) - 1;
  return found->front().is_null() ? nullptr : &found->front();
}

absl::StatusOr<std::vector<Annotation>> ReadSequence(const json& sequence, const std::string& place,
                                                     std::string_view track, BabelCounts& counts) {
  if (!sequence.is_object()) return JsonTypeError(place, "an object", sequence);
  std::string file_name;
  absl::Status status = ReadJsonText(sequence, "feat_p", place, file_name);
  if (status.ok() && file_name.empty()) {
    status = absl::InvalidArgumentError(place + ": feat_p: expected a file name, found nothing");
  }
  if (!status.ok()) return status;
  const json* annotator = FindAnnotator(sequence, "frame_ann", "frame_anns", counts);
  const bool has_times = annotator != nullptr;
  if (!has_times) annotator = FindAnnotator(sequence, "seq_ann", "seq_anns", counts);
  std::vector<Annotation> annotations;
  if (annotator == nullptr) return annotations;
  const std::string inner = place + (has_times ? ".frame_ann" : ".seq_ann");
  if (!annotator->is_object()) return JsonTypeError(inner, "an object", *annotator);
  const auto labels = annotator->find("labels");
  if (labels == annotator->end() || labels->is_null()) return annotations;
  if (!labels->is_array()) return JsonTypeError(inner + ".labels", "an array", *labels);
  for (std::size_t i = 0; i < labels->size(); ++i) {
    status = AddLabel((*labels)[i], fmt::format("{}.labels[{}]", inner, i), FileStem(file_name),
                      has_times, counts, annotations);
    if (!status.ok()) return status;
  }
  if (status = AssignTracks(track, annotations); !status.ok()) return status;
  return annotations;
}

json LabelOf(const Annotation& annotation, const AnnotatedClip& clip, const std::string& id) {
  return {{"raw_label", annotation.label},
          {"proc_label", annotation.label},
          {"seg_id", id},
          {"act_cat", {annotation.label}},
          {"start_t", annotation.start_seconds},
          {"end_t", annotation.end_seconds.value_or(clip.duration_seconds)}};
}

}  // namespace

absl::StatusOr<AnnotationFile> ReadBabel(const AnnotationSource& source) {
  const auto document = ParseJsonDocument(source.file_name, source.bytes);
  if (!document.ok()) return document.status();
  if (!document->is_object()) {
    return JsonTypeError(std::string(source.file_name), "an object of sequences", *document);
  }
  AnnotationFile file;
  BabelCounts counts;
  for (const auto& [id, sequence] : document->items()) {
    auto annotations = ReadSequence(sequence, fmt::format("{}: {}", source.file_name, id),
                                    source.default_track, counts);
    if (!annotations.ok()) return annotations.status();
    std::ranges::move(*annotations, std::back_inserter(file.annotations));
  }
  if (counts.without_duration > 0) {
    file.notes.push_back(fmt::format("{}: labels that end before they begin, not imported: {}",
                                     source.file_name, counts.without_duration));
  }
  if (counts.other_annotators > 0) {
    file.notes.push_back(fmt::format("{}: labels of further annotators, not imported: {}",
                                     source.file_name, counts.other_annotators));
  }
  return file;
}

std::string WriteBabel(const std::vector<AnnotatedClip>& clips,
                       const std::vector<Annotation>& annotations) {
  std::map<std::string_view, std::vector<const Annotation*>> of_clip;
  for (const Annotation& annotation : annotations) of_clip[annotation.clip].push_back(&annotation);
  json document = json::object();
  for (std::size_t i = 0; i < clips.size(); ++i) {
    json labels = json::array();
    for (const Annotation* const annotation : of_clip[clips[i].clip]) {
      labels.push_back(LabelOf(*annotation, clips[i], fmt::format("{}-{}", i, labels.size())));
    }
    document[std::to_string(i)] = {{"babel_sid", i},
                                   {"feat_p", clips[i].file_name},
                                   {"dur", clips[i].duration_seconds},
                                   {"seq_ann", nullptr},
                                   {"frame_ann", {{"labels", std::move(labels)}}}};
  }
  return document.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace motiondb::client
