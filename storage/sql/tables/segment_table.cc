#include "storage/sql/tables/segment_table.h"

#include <string_view>

#include "core/motion/error.h"
#include "storage/sql/tables/enum_text.h"

namespace motiondb::storage {
namespace {

// Returns a query for the columns that ReadSegments reads.
std::string SelectSegmentColumns(std::string_view rest) {
  return fmt::format(
      "SELECT segment.id, track, label, start_seconds, end_seconds, source, confidence, "
      "segment.revision, author, segment.create_time_us, update_time_us, clip.id "
      "FROM segment JOIN clip USING (clip_key) WHERE {}",
      rest);
}

absl::StatusOr<std::vector<SegmentRecord>> ReadSegments(Statement row,
                                                        const std::string& database) {
  std::vector<SegmentRecord> segments;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return segments;
    SegmentRecord& segment = segments.emplace_back();
    segment.database = database;
    segment.id = row.Text(0);
    segment.track = row.Text(1);
    segment.label = row.Text(2);
    segment.start_seconds = row.Real(3);
    if (!row.IsNull(4)) segment.end_seconds = row.Real(4);
    MOTIONDB_ASSIGN_OR_RETURN(segment.source, FromText<SegmentSource>(row.Text(5)));
    segment.confidence = row.Real(6);
    segment.revision = row.Integer(7);
    segment.author = row.Text(8);
    segment.create_time_us = row.Integer(9);
    segment.update_time_us = row.Integer(10);
    segment.clip = row.Text(11);
  }
}

}  // namespace

absl::Status InsertSegments(Connection& connection, const ClipRef& clip,
                            std::span<const SegmentRecord> segments) {
  for (const SegmentRecord& segment : segments) {
    MOTIONDB_RETURN_IF_ERROR(connection.InsertRow(
        "segment",
        "INSERT INTO segment (database_key, clip_key, id, track, label, start_seconds, "
        "end_seconds, source, confidence, revision, author, create_time_us, "
        "update_time_us) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        clip.database_key, clip.clip_key, segment.id, segment.track, segment.label,
        segment.start_seconds, segment.end_seconds, ToText(segment.source), segment.confidence,
        segment.revision, segment.author, segment.create_time_us, segment.update_time_us));
  }
  return absl::OkStatus();
}

absl::Status UpdateSegment(Connection& connection, std::int64_t clip_key,
                           const SegmentRecord& segment) {
  std::int64_t key = 0;
  {
    Statement row = connection.Query(
        "SELECT segment_key FROM segment WHERE clip_key = ? AND id = ?", clip_key, segment.id);
    MOTIONDB_RETURN_IF_ERROR(row.Step().status());
    key = row.Integer(0);
  }
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE segment SET track = ?, label = ?, start_seconds = ?, end_seconds = ?, "
                 "source = ?, confidence = ?, revision = ?, author = ?, create_time_us = ?, "
                 "update_time_us = ? WHERE segment_key = ?",
                 segment.track, segment.label, segment.start_seconds, segment.end_seconds,
                 ToText(segment.source), segment.confidence, segment.revision, segment.author,
                 segment.create_time_us, segment.update_time_us, key)
          .Run());
  return connection.SetRowChecksum("segment", key);
}

absl::Status DeleteSegment(Connection& connection, std::int64_t clip_key, const std::string& id) {
  return connection.Query("DELETE FROM segment WHERE clip_key = ? AND id = ?", clip_key, id).Run();
}

absl::StatusOr<std::vector<SegmentRecord>> SelectSegments(Connection& connection,
                                                          const ClipRef& clip) {
  return ReadSegments(
      connection.Query(
          SelectSegmentColumns("segment.clip_key = ? ORDER BY track, start_seconds, segment.id"),
          clip.clip_key),
      clip.database);
}

absl::StatusOr<std::vector<SegmentRecord>> SelectChangedSegments(Connection& connection,
                                                                 std::int64_t database_key,
                                                                 const std::string& database,
                                                                 std::int64_t after,
                                                                 std::int64_t last) {
  return ReadSegments(
      connection.Query(SelectSegmentColumns("segment.database_key = ? AND segment.revision > ? AND "
                                            "segment.revision <= ? AND deleted = 0 "
                                            "ORDER BY segment.revision, clip.id, segment.id"),
                       database_key, after, last),
      database);
}

}  // namespace motiondb::storage
