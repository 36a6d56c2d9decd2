// Clips and segments as filters and lists see them: the stored records without what only a single
// clip needs. Immutable while a Catalog has them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "storage/records.h"

namespace motiondb::server {

// Fields as in storage::SegmentRecord. Those that most filters compare are first, in one cache
// line.
struct CatalogSegment {
  std::string label;
  std::string track;
  double start_seconds = 0;
  std::optional<double> end_seconds;  // none: the end of the clip
  double confidence = 1;
  storage::SegmentSource source = storage::SegmentSource::kPerson;
  std::string id;
  std::string author;
  std::int64_t create_time_us = 0;
  std::int64_t update_time_us = 0;

  bool is_on_action_track() const { return track == storage::kActionTrack; }
};

// Amount of stored data, or a change of it.
struct StoredAmount {
  std::int32_t clip_count = 0;
  std::int64_t frame_count = 0;
  std::int64_t byte_count = 0;

  StoredAmount operator-() const { return {-clip_count, -frame_count, -byte_count}; }
  StoredAmount operator+(const StoredAmount& other) const {
    return {clip_count + other.clip_count, frame_count + other.frame_count,
            byte_count + other.byte_count};
  }
};

// Fields as in storage::ClipRecord; those that most filters compare are first.
struct CatalogClip {
  std::vector<CatalogSegment> segments;  // in order of track, start and id
  // False until the change that puts the clip: a change of a segment can precede it.
  bool is_stored = false;
  core::FileFormat format = core::FileFormat::kBvh;
  std::int32_t frame_count = 0;
  double duration_seconds = 0;
  std::int64_t create_time_us = 0;
  std::int64_t edit_time_us = 0;  // 0: not edited
  std::string subject;
  std::string id;
  std::vector<std::string> tags;  // ascending, distinct
  storage::Fields fields;
  std::string title;
  std::string file_name;
  std::string take;
  std::string description;
  std::int64_t byte_count = 0;  // of its blobs
};

CatalogSegment ToCatalogSegment(const storage::SegmentRecord& record);

// Sets everything but the segments.
void SetRecord(const storage::ClipRecord& record, CatalogClip& clip);

// The amount of one clip, a CatalogClip or a storage::ClipRecord.
template <typename Clip>
StoredAmount AmountOf(const Clip& clip) {
  return {1, clip.frame_count, clip.byte_count};
}

// End of a segment in its clip.
inline double EndSeconds(const CatalogClip& clip, const CatalogSegment& segment) {
  return segment.end_seconds.value_or(clip.duration_seconds);
}

}  // namespace motiondb::server
