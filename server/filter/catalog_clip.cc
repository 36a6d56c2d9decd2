#include "server/filter/catalog_clip.h"

namespace motiondb::server {

CatalogSegment ToCatalogSegment(const storage::SegmentRecord& record) {
  return {.label = record.label,
          .track = record.track,
          .start_seconds = record.start_seconds,
          .end_seconds = record.end_seconds,
          .confidence = record.confidence,
          .source = record.source,
          .id = record.id,
          .author = record.author,
          .create_time_us = record.create_time_us,
          .update_time_us = record.update_time_us};
}

void SetRecord(const storage::ClipRecord& record, CatalogClip& clip) {
  clip.id = record.id;
  clip.subject = record.subject;
  clip.title = record.title;
  clip.description = record.description;
  clip.file_name = record.file_name;
  clip.take = record.given.take;
  clip.format = record.format;
  clip.frame_count = record.frame_count;
  clip.duration_seconds = record.duration_seconds;
  clip.create_time_us = record.create_time_us;
  clip.edit_time_us = record.edit_time_us;
  clip.tags = record.tags;
  clip.fields = record.fields;
  clip.byte_count = record.byte_count;
  clip.is_stored = true;
}

}  // namespace motiondb::server
