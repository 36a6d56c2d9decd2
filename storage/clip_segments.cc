#include "storage/clip_segments.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/motion/error.h"
#include "storage/annotation_store.h"

namespace motiondb::storage {
namespace {

double HalfFrame(const ClipRecord& clip) {
  return clip.frame_count > 0 ? 0.5 * clip.duration_seconds / clip.frame_count : 0;
}

double EndOf(const SegmentRecord& segment) {
  return segment.end_seconds.value_or(std::numeric_limits<double>::infinity());
}

bool HasTrack(std::span<const SegmentRecord> segments, const std::string& track) {
  return std::ranges::find(segments, track, &SegmentRecord::track) != segments.end();
}

bool HasId(std::span<const SegmentRecord> segments, const std::string& id) {
  return std::ranges::find(segments, id, &SegmentRecord::id) != segments.end();
}

// Adds the given segments of a new clip.
absl::Status AddGiven(const NewClip& clip, const ClipRecord& record, const ChangeStamp& stamp,
                      std::vector<SegmentRecord>& segments) {
  for (SegmentRecord segment : clip.segments) {
    segment.database = record.database;
    segment.clip = record.id;
    if (segment.id.empty()) segment.id = ChooseSegmentId(segments, stamp.revision);
    if (HasId(segments, segment.id)) {
      return absl::AlreadyExistsError(
          fmt::format("clip '{}' already has a segment '{}'", record.id, segment.id));
    }
    MOTIONDB_RETURN_IF_ERROR(FitToClip(record, segment));
    MOTIONDB_RETURN_IF_ERROR(CheckOverlap(segment, segments));
    Stamp(segment, stamp);
    segments.push_back(std::move(segment));
  }
  return absl::OkStatus();
}

// Sets the label of an ingested clip, unless its track has segments that do not cover the clip.
void SetImportedLabel(const ClipRecord& record, const ChangeStamp& stamp,
                      std::vector<SegmentRecord>& segments) {
  const auto covering = std::ranges::find_if(segments, [](const SegmentRecord& segment) {
    return segment.track == kActionTrack && CoversClip(segment);
  });
  if (covering != segments.end()) {
    if (covering->label == record.label) return;
    covering->label = record.label;
    covering->source = SegmentSource::kImport;
    covering->confidence = 1;
    Stamp(*covering, stamp);
  } else if (!HasTrack(segments, kActionTrack)) {
    SegmentRecord segment;
    segment.database = record.database;
    segment.clip = record.id;
    segment.id =
        HasId(segments, kLabelSegment) ? ChooseSegmentId(segments, stamp.revision) : kLabelSegment;
    segment.label = record.label;
    segment.source = SegmentSource::kImport;
    Stamp(segment, stamp);
    segments.push_back(std::move(segment));
  }
}

}  // namespace

void Stamp(SegmentRecord& segment, const ChangeStamp& stamp) {
  segment.revision = stamp.revision;
  segment.author = stamp.author;
  segment.update_time_us = stamp.time_us;
  if (segment.create_time_us == 0) segment.create_time_us = stamp.time_us;
}

bool CoversClip(const SegmentRecord& segment) {
  return segment.start_seconds == 0 && !segment.end_seconds;
}

std::string LabelOf(std::span<const SegmentRecord> segments) {
  for (const SegmentRecord& segment : segments) {
    if (segment.track == kActionTrack && CoversClip(segment)) return segment.label;
  }
  return "";
}

void SortSegments(std::vector<SegmentRecord>& segments) {
  std::ranges::sort(segments, {}, [](const SegmentRecord& segment) {
    return std::tie(segment.track, segment.start_seconds);
  });
}

absl::Status FitToClip(const ClipRecord& clip, SegmentRecord& segment) {
  const double half_frame = HalfFrame(clip);
  const double clip_end = clip.duration_seconds;
  if (!std::isfinite(segment.start_seconds) || segment.start_seconds < 0) {
    return core::FieldViolation("start_seconds", "expected a time from 0 on, got {} s",
                                segment.start_seconds);
  }
  if (segment.end_seconds) {
    const double end = *segment.end_seconds;
    if (!(end <= clip_end + half_frame)) {
      return core::FieldViolation("end_seconds",
                                  "expected a time up to the end of clip '{}' at {} s, got {} s",
                                  clip.id, clip_end, end);
    }
    if (!(end > segment.start_seconds)) {
      return core::FieldViolation("end_seconds",
                                  "expected a time after the start at {} s, got {} s",
                                  segment.start_seconds, end);
    }
    if (end >= clip_end - half_frame) segment.end_seconds.reset();
  }
  if (!segment.end_seconds && segment.start_seconds > 0 && segment.start_seconds >= clip_end) {
    return core::FieldViolation("start_seconds",
                                "expected a time before the end of clip '{}' at {} s, got {} s",
                                clip.id, clip_end, segment.start_seconds);
  }
  return absl::OkStatus();
}

absl::Status CheckOverlap(const SegmentRecord& segment, std::span<const SegmentRecord> others) {
  for (const SegmentRecord& other : others) {
    const bool overlaps = other.id != segment.id && other.track == segment.track &&
                          segment.start_seconds < EndOf(other) &&
                          other.start_seconds < EndOf(segment);
    if (!overlaps) continue;
    const auto describe = [](const SegmentRecord& of) {
      return of.end_seconds ? fmt::format("{} to {} s", of.start_seconds, *of.end_seconds)
                            : fmt::format("{} s to the end", of.start_seconds);
    };
    return core::WithResource(
        "segment",
        fmt::format("databases/{}/clips/{}/segments/{}", other.database, other.clip, other.id),
        core::WithReason(
            "SEGMENTS_OVERLAP",
            core::FailedPrecondition("clip '{}', track '{}': the segment from {} overlaps segment "
                                     "'{}' ('{}') from {}; change or delete that one first",
                                     segment.clip, segment.track, describe(segment), other.id,
                                     other.label, describe(other))));
  }
  return absl::OkStatus();
}

std::string ChooseSegmentId(std::span<const SegmentRecord> segments, std::int64_t revision) {
  std::string id = fmt::format("s{}", revision);
  for (int number = 2; HasId(segments, id); ++number) id = fmt::format("s{}-{}", revision, number);
  return id;
}

absl::StatusOr<std::vector<SegmentRecord>> SegmentsOf(const NewClip& clip, const ClipRecord& record,
                                                      std::vector<SegmentRecord> former,
                                                      const ChangeStamp& stamp) {
  std::vector<SegmentRecord> segments = std::move(former);
  std::erase_if(segments, [&](const SegmentRecord& segment) {
    return HasTrack(clip.segments, segment.track);
  });
  for (SegmentRecord& segment : segments) {
    if (segment.database == record.database && segment.clip == record.id) continue;
    segment.database = record.database;
    segment.clip = record.id;
    Stamp(segment, stamp);
  }
  AdaptToClip(record, stamp, segments);
  MOTIONDB_RETURN_IF_ERROR(AddGiven(clip, record, stamp, segments));
  if (!record.label.empty() && !HasTrack(clip.segments, kActionTrack)) {
    SetImportedLabel(record, stamp, segments);
  }
  SortSegments(segments);
  return segments;
}

void AdaptToClip(const ClipRecord& clip, const ChangeStamp& stamp,
                 std::vector<SegmentRecord>& segments) {
  std::erase_if(segments, [&](const SegmentRecord& segment) {
    return segment.start_seconds > 0 && segment.start_seconds >= clip.duration_seconds;
  });
  const double last_end = clip.duration_seconds - HalfFrame(clip);
  for (SegmentRecord& segment : segments) {
    if (!segment.end_seconds || *segment.end_seconds < last_end) continue;
    segment.end_seconds.reset();
    Stamp(segment, stamp);
  }
}

void KeepAnnotations(const ClipRecord& before, ClipRecord& record) {
  if (record.subject.empty()) record.subject = before.subject;
  if (record.title.empty()) record.title = before.title;
  if (record.description.empty()) record.description = before.description;
  if (record.tags.empty()) record.tags = before.tags;
  if (record.fields.empty()) record.fields = before.fields;
  record.edit_time_us = before.edit_time_us;
}

void CopyAnnotations(const ClipRecord& from, ClipRecord& record) {
  record.subject = from.subject;
  record.title = from.title;
  record.description = from.description;
  record.tags = from.tags;
  record.fields = from.fields;
  record.edit_time_us = from.edit_time_us;
}

bool SameState(const ClipRecord& a, const ClipRecord& b) {
  const auto state = [](const ClipRecord& clip) {
    return std::tie(clip.label, clip.subject, clip.title, clip.description, clip.tags, clip.fields);
  };
  return state(a) == state(b);
}

bool SameState(const SegmentRecord& a, const SegmentRecord& b) {
  const auto state = [](const SegmentRecord& segment) {
    return std::tie(segment.track, segment.label, segment.start_seconds, segment.end_seconds,
                    segment.source, segment.confidence);
  };
  return state(a) == state(b);
}

}  // namespace motiondb::storage
