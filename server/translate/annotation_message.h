// Sets messages from annotations: segments, edits, and changes of a database.
#pragma once

#include <string>

#include "storage/annotation_store.h"

namespace motiondb::v1 {
class Clip;
class Edit;
class Segment;
class WatchDatabaseResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Sets the annotations of a clip: title, description, tags, fields, etag and time of the last edit.
void SetAnnotations(const storage::ClipRecord& record, v1::Clip& message);
void SetSegment(const storage::SegmentRecord& record, v1::Segment& message);
void SetEdit(const storage::EditRecord& record, v1::Edit& message);
void SetChange(const std::string& database, const storage::ChangeRecord& record,
               v1::WatchDatabaseResponse& message);

}  // namespace motiondb::server
