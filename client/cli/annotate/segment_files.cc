#include "client/cli/annotate/segment_files.h"

#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>

#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

constexpr double kSameTime = 1e-6;       // seconds
constexpr double kMaxLateSeconds = 0.1;  // of an end after the end of its clip
constexpr std::size_t kMaxSegmentId = 63;

// FNV-1a, 64 bits.
std::uint64_t HashOf(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  }
  return hash;
}

// An annotation whose clip is known.
struct PlacedAnnotation {
  const Annotation* annotation = nullptr;
  const v1::Clip* clip = nullptr;
  double end_seconds = 0;
  bool ends_with_clip = false;
};

absl::Status ErrorAt(const Annotation& annotation, const std::string& what) {
  return absl::InvalidArgumentError(fmt::format("{}: {}", annotation.place, what));
}

absl::StatusOr<PlacedAnnotation> Place(const Annotation& annotation, const v1::Clip& clip) {
  const double duration = clip.duration_seconds();
  PlacedAnnotation placed{&annotation, &clip, annotation.end_seconds.value_or(duration)};
  if (annotation.start_seconds >= duration) {
    return ErrorAt(annotation,
                   fmt::format("start: expected less than {:g} s, the duration of clip "
                               "'{}', found {:g} s",
                               duration, ShortName(clip.name()), annotation.start_seconds));
  }
  if (placed.end_seconds > duration + kMaxLateSeconds) {
    return ErrorAt(annotation, fmt::format("end: expected at most {:g} s, the duration of clip "
                                           "'{}', found {:g} s",
                                           duration, ShortName(clip.name()), placed.end_seconds));
  }
  placed.ends_with_clip = placed.end_seconds >= duration;
  placed.end_seconds = std::min(placed.end_seconds, duration);
  return placed;
}

absl::Status CheckOverlaps(std::vector<PlacedAnnotation> placed) {
  std::ranges::stable_sort(placed, [](const auto& a, const auto& b) {
    return std::tie(a.clip->name(), a.annotation->track, a.annotation->start_seconds) <
           std::tie(b.clip->name(), b.annotation->track, b.annotation->start_seconds);
  });
  for (std::size_t i = 1; i < placed.size(); ++i) {
    const PlacedAnnotation& before = placed[i - 1];
    const Annotation& annotation = *placed[i].annotation;
    const bool is_same_track =
        before.clip == placed[i].clip && before.annotation->track == annotation.track;
    if (!is_same_track || annotation.start_seconds >= before.end_seconds) continue;
    return ErrorAt(annotation, fmt::format("start: overlaps {} on track '{}' of clip '{}'",
                                           before.annotation->place, annotation.track,
                                           ShortName(before.clip->name())));
  }
  return absl::OkStatus();
}

std::string TrackOf(const v1::Segment& segment) {
  return segment.track().empty() ? "action" : segment.track();
}

bool HasTimes(const v1::Segment& segment, const PlacedAnnotation& placed) {
  const double end =
      segment.has_end_seconds() ? segment.end_seconds() : placed.clip->duration_seconds();
  return std::abs(segment.start_seconds() - placed.annotation->start_seconds) < kSameTime &&
         std::abs(end - placed.end_seconds) < kSameTime;
}

void SetTimes(const PlacedAnnotation& placed, v1::Segment& segment) {
  segment.set_start_seconds(placed.annotation->start_seconds);
  if (placed.ends_with_clip) {
    segment.clear_end_seconds();
  } else {
    segment.set_end_seconds(placed.end_seconds);
  }
}

v1::SegmentSource SourceOf(const Annotation& annotation) {
  return annotation.source.empty() ? v1::SEGMENT_SOURCE_IMPORT : SegmentSourceOf(annotation.source);
}

v1::CreateSegmentRequest CreateRequest(const PlacedAnnotation& placed, const std::string& id) {
  v1::CreateSegmentRequest request;
  request.set_parent(placed.clip->name());
  request.set_segment_id(id);
  v1::Segment& segment = *request.mutable_segment();
  segment.set_track(placed.annotation->track);
  segment.set_label(placed.annotation->label);
  SetTimes(placed, segment);
  segment.set_source(SourceOf(*placed.annotation));
  if (placed.annotation->confidence) segment.set_confidence(*placed.annotation->confidence);
  return request;
}

// Returns the change of a stored segment; without paths in its mask if there is none.
v1::UpdateSegmentRequest UpdateSegmentRequestOf(const PlacedAnnotation& placed,
                                                const v1::Segment& stored) {
  const Annotation& annotation = *placed.annotation;
  v1::UpdateSegmentRequest request;
  v1::Segment& segment = *request.mutable_segment();
  segment.set_name(stored.name());
  segment.set_etag(stored.etag());
  const auto change = [&](const char* field) { request.mutable_update_mask()->add_paths(field); };
  if (!HasTimes(stored, placed)) {
    SetTimes(placed, segment);
    change("start_seconds");
    change("end_seconds");
  }
  const bool has_new_label = stored.label() != annotation.label;
  if (has_new_label) {
    segment.set_label(annotation.label);
    change("label");
  }
  const double stored_confidence = stored.has_confidence() ? stored.confidence() : 1;
  if (annotation.confidence && *annotation.confidence != stored_confidence) {
    segment.set_confidence(*annotation.confidence);
    change("confidence");
  }
  const bool states_source = !annotation.source.empty() || has_new_label;
  if (states_source && SourceOf(annotation) != stored.source()) {
    segment.set_source(SourceOf(annotation));
    change("source");
  }
  return request;
}

// Stored segments by their names, and by clip, track and start in microseconds.
struct StoredSegments {
  explicit StoredSegments(const std::vector<v1::Segment>& segments) {
    for (const v1::Segment& segment : segments) {
      by_name[segment.name()] = &segment;
      by_start.emplace(
          StartKey(ParentOf(segment), TrackOf(segment), Microseconds(segment.start_seconds())),
          &segment);
    }
  }

  using StartKey = std::tuple<std::string, std::string, std::int64_t>;

  static std::string ParentOf(const v1::Segment& segment) {
    return segment.name().substr(0, segment.name().find("/segments/"));
  }
  static std::int64_t Microseconds(double seconds) { return std::llround(seconds * 1e6); }

  // Returns the segment with the name, else one with the same track and times, or null.
  const v1::Segment* Find(const PlacedAnnotation& placed, const std::string& id) const {
    const std::string& clip = placed.clip->name();
    if (const auto found = by_name.find(clip + "/segments/" + id); found != by_name.end()) {
      return found->second;
    }
    const std::int64_t start = Microseconds(placed.annotation->start_seconds);
    const std::string& track = placed.annotation->track;
    const auto end = by_start.upper_bound(StartKey(clip, track, start + 1));
    for (auto each = by_start.lower_bound(StartKey(clip, track, start - 1)); each != end; ++each) {
      if (HasTimes(*each->second, placed)) return each->second;
    }
    return nullptr;
  }

  std::map<std::string, const v1::Segment*> by_name;
  std::multimap<StartKey, const v1::Segment*> by_start;
};

void AddChange(const PlacedAnnotation& placed, const StoredSegments& stored,
               SegmentImport& import) {
  const Annotation& annotation = *placed.annotation;
  const std::string id =
      ImportedSegmentId(annotation.track, annotation.start_seconds, placed.end_seconds);
  v1::Change change;
  if (const v1::Segment* const segment = stored.Find(placed, id)) {
    *change.mutable_update_segment() = UpdateSegmentRequestOf(placed, *segment);
    if (change.update_segment().update_mask().paths().empty()) {
      ++import.unchanged;
      return;
    }
    ++import.updated;
  } else {
    *change.mutable_create_segment() = CreateRequest(placed, id);
    ++import.created;
  }
  import.changes.push_back(std::move(change));
  import.places.push_back(annotation.place);
}

}  // namespace

CLI::Option* AddFormatOption(CLI::App& command, std::string& format, const char* description) {
  return command.add_option("--format", format, description)
      ->type_name("tsv|json|babel|textgrid")
      ->check(CLI::IsMember({"tsv", "json", "babel", "textgrid"}));
}

std::optional<AnnotationFormat> NamedFormat(const std::string& name) {
  if (name == "tsv") return AnnotationFormat::kTsv;
  if (name == "json") return AnnotationFormat::kJson;
  if (name == "babel") return AnnotationFormat::kBabel;
  if (name == "textgrid") return AnnotationFormat::kTextGrid;
  return std::nullopt;
}

v1::SegmentSource SegmentSourceOf(const std::string& name) {
  if (name == "person") return v1::SEGMENT_SOURCE_PERSON;
  if (name == "import") return v1::SEGMENT_SOURCE_IMPORT;
  if (name == "suggestion") return v1::SEGMENT_SOURCE_SUGGESTION;
  return v1::SEGMENT_SOURCE_UNSPECIFIED;
}

std::string ImportedSegmentId(const std::string& track, double start_seconds, double end_seconds) {
  const std::string times = fmt::format("-{:.0f}-{:.0f}", start_seconds * 1000, end_seconds * 1000);
  if (track.size() + times.size() <= kMaxSegmentId) return track + times;
  return fmt::format("{:016x}", HashOf(track + times));
}

absl::StatusOr<SegmentImport> PlanSegmentImport(const ClipIndex& clips,
                                                const std::vector<v1::Segment>& stored,
                                                const std::vector<Annotation>& annotations) {
  SegmentImport import;
  std::vector<PlacedAnnotation> placed;
  int late_ends = 0;
  for (const Annotation& annotation : annotations) {
    const v1::Clip* const clip = clips.Find(annotation.clip);
    if (clip == nullptr) {
      import.unmatched.insert(annotation.clip);
      continue;
    }
    const auto place = Place(annotation, *clip);
    if (!place.ok()) return place.status();
    if (annotation.end_seconds && *annotation.end_seconds > place->end_seconds) ++late_ends;
    placed.push_back(*place);
  }
  if (absl::Status status = CheckOverlaps(placed); !status.ok()) return status;
  const StoredSegments stored_segments(stored);
  for (const PlacedAnnotation& each : placed) AddChange(each, stored_segments, import);
  if (late_ends > 0) {
    import.notes.push_back(fmt::format("ends up to {:g} s after their clip, set to its end: {}",
                                       kMaxLateSeconds, late_ends));
  }
  return import;
}

std::vector<Annotation> AnnotationsOf(const std::vector<v1::Segment>& segments) {
  std::vector<Annotation> annotations;
  for (const v1::Segment& segment : segments) {
    Annotation& annotation = annotations.emplace_back();
    annotation.clip = ShortName(StoredSegments::ParentOf(segment));
    annotation.track = TrackOf(segment);
    annotation.label = segment.label();
    annotation.start_seconds = segment.start_seconds();
    if (segment.has_end_seconds()) annotation.end_seconds = segment.end_seconds();
    if (segment.has_confidence()) annotation.confidence = segment.confidence();
    if (segment.source() != v1::SEGMENT_SOURCE_UNSPECIFIED) {
      annotation.source = EnumValueText(v1::SegmentSource_Name(segment.source()));
    }
  }
  return annotations;
}

}  // namespace motiondb::client
