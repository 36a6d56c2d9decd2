// Rows of the table `segment`. The functions run in the caller's transaction. A deleted clip keeps
// its segments as long as its row, because a model can use them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/records.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/clip_row.h"

namespace motiondb::storage {

// SQL expression for the label of a row of `clip`: LabelOf its segments.
inline constexpr char kLabelColumn[] =
    "COALESCE((SELECT label FROM segment WHERE segment.clip_key = clip.clip_key AND track = "
    "'action' "
    "AND start_seconds = 0.0 AND end_seconds IS NULL), '')";

absl::Status InsertSegments(Connection& connection, const ClipRef& clip,
                            std::span<const SegmentRecord> segments);
absl::Status UpdateSegment(Connection& connection, std::int64_t clip_key,
                           const SegmentRecord& segment);
absl::Status DeleteSegment(Connection& connection, std::int64_t clip_key, const std::string& id);

// Returns the segments of a clip, in order of track and start.
absl::StatusOr<std::vector<SegmentRecord>> SelectSegments(Connection& connection,
                                                          const ClipRef& clip);
// Returns the segments of clips that are not deleted with a revision above `after` up to `last`, in
// order of revision, clip and id.
absl::StatusOr<std::vector<SegmentRecord>> SelectChangedSegments(Connection& connection,
                                                                 std::int64_t database_key,
                                                                 const std::string& database,
                                                                 std::int64_t after,
                                                                 std::int64_t last);

}  // namespace motiondb::storage
