// Rules of the segments of a clip. The same for every store.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/label_tracks.h"
#include "storage/records.h"

namespace motiondb::storage {

// Author, time and revision of a change.
struct ChangeStamp {
  std::string author;
  std::int64_t time_us = 0;
  std::int64_t revision = 0;
};

// Sets the fields of a new or changed segment that the store sets.
void Stamp(SegmentRecord& segment, const ChangeStamp& stamp);

// Returns whether a segment covers its clip. (An end at the end of the clip is stored as none.)
bool CoversClip(const SegmentRecord& segment);

// Returns the label of the segment of track kActionTrack that covers the clip; empty if there is
// none.
std::string LabelOf(std::span<const SegmentRecord> segments);

// Returns the labels of a clip of `frame_count` frames. A segment has the frames nearest to its
// start and end; one without a frame is left out. `segments`: in order of track and start;
// SegmentRecord, or another type with its fields.
template <typename Segment>
core::LabelTracks LabelTracksOf(const std::vector<Segment>& segments, double frame_rate_hz,
                                int frame_count) {
  const auto frame_at = [&](double seconds) {
    return static_cast<int>(
        std::clamp(std::round(seconds * frame_rate_hz), 0.0, static_cast<double>(frame_count)));
  };
  std::map<std::string, std::vector<core::LabelSpan>> spans;
  for (const Segment& segment : segments) {
    const int first = frame_at(segment.start_seconds);
    const int end = segment.end_seconds ? frame_at(*segment.end_seconds) : frame_count;
    if (end > first) spans[segment.track].push_back({segment.label, first, end - first});
  }
  core::LabelTracks labels;
  for (auto& [track, of_track] : spans) labels.Set(track, std::move(of_track));
  return labels;
}

// Sorts segments by track and start.
void SortSegments(std::vector<SegmentRecord>& segments);

// Checks the times of a segment, and removes an end within half a frame of the end of the clip.
// INVALID_ARGUMENT if the segment does not end after it starts, starts before the clip, or ends
// more than half a frame after it.
absl::Status FitToClip(const ClipRecord& clip, SegmentRecord& segment);

// FAILED_PRECONDITION with reason SEGMENTS_OVERLAP if `segment` overlaps another one of its track.
absl::Status CheckOverlap(const SegmentRecord& segment, std::span<const SegmentRecord> others);

// Returns an id for a new segment that none of `segments` has.
std::string ChooseSegmentId(std::span<const SegmentRecord> segments, std::int64_t revision);

// Returns the segments of `clip`, which is stored as `record`, in place of a clip with the segments
// `former` (none: it is new). The given segments replace the former ones of their tracks. A label
// makes the segment of track kActionTrack that covers the clip, unless the track has others. Errors
// as of AnnotationStore::Edit.
absl::StatusOr<std::vector<SegmentRecord>> SegmentsOf(const NewClip& clip, const ClipRecord& record,
                                                      std::vector<SegmentRecord> former,
                                                      const ChangeStamp& stamp);

// Adapts segments to a clip whose duration has changed: an end after the clip is removed, and
// segments that start after the clip are left out.
void AdaptToClip(const ClipRecord& clip, const ChangeStamp& stamp,
                 std::vector<SegmentRecord>& segments);

// Copies those annotations of the clip `before`, and its subject, that `record`, which replaces it,
// does not have.
void KeepAnnotations(const ClipRecord& before, ClipRecord& record);

// Copies all annotations of `from`, and its subject.
void CopyAnnotations(const ClipRecord& from, ClipRecord& record);

// Returns whether everything that an edit can change is equal.
bool SameState(const ClipRecord& a, const ClipRecord& b);
bool SameState(const SegmentRecord& a, const SegmentRecord& b);

}  // namespace motiondb::storage
