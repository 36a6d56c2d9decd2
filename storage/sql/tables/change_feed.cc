#include "storage/sql/tables/change_feed.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/motion/error.h"
#include "storage/edit_plan.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/segment_table.h"

namespace motiondb::storage {
namespace {

constexpr std::int64_t kEnd = std::numeric_limits<std::int64_t>::max();

// Queries of the revisions of changes: database key, revision, limit.
constexpr std::array<std::string_view, 3> kRevisions = {
    "SELECT revision FROM clip WHERE database_key = ? AND deleted = 0 AND revision > ? "
    "ORDER BY revision LIMIT ?",
    "SELECT segment.revision FROM segment JOIN clip USING (clip_key) WHERE segment.database_key = "
    "? AND segment.revision > ? AND deleted = 0 ORDER BY segment.revision LIMIT ?",
    "SELECT revision FROM tombstone WHERE database_key = ? AND revision > ? "
    "ORDER BY revision LIMIT ?"};

// The last change of the model.
struct ModelRevision {
  std::int64_t revision = 0;
  ModelPut put;
};

absl::StatusOr<std::optional<ModelRevision>> SelectModelRevision(Connection& connection,
                                                                 std::int64_t database_key,
                                                                 std::int64_t after) {
  Statement row = connection.Query(
      "SELECT revision, version, current FROM model WHERE database_key = ? AND revision > ? "
      "ORDER BY revision DESC LIMIT 1",
      database_key, after);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  const bool current = row.Integer(2) != 0;
  return ModelRevision{row.Integer(0), {current ? row.Integer<std::int32_t>(1) : 0}};
}

// Returns the revision of the change number `limit` after a revision; kEnd if there are fewer.
absl::StatusOr<std::int64_t> RevisionOfLast(Connection& connection, std::int64_t database_key,
                                            std::int64_t after, int limit,
                                            const std::optional<ModelRevision>& model) {
  std::vector<std::int64_t> revisions;
  for (const std::string_view query : kRevisions) {
    Statement row = connection.Query(query, database_key, after, limit);
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) break;
      revisions.push_back(row.Integer(0));
    }
  }
  if (model) revisions.push_back(model->revision);
  if (std::ssize(revisions) < limit) return kEnd;
  const auto last = revisions.begin() + (limit - 1);
  std::ranges::nth_element(revisions, last);
  return *last;
}

absl::Status InsertTombstone(Connection& connection, const ClipRef& clip,
                             const std::string& segment, std::int64_t revision) {
  std::int64_t number = 0;
  {
    Statement last = connection.Query(
        "SELECT COALESCE(max(number), 0) FROM tombstone WHERE database_key = ?", clip.database_key);
    MOTIONDB_RETURN_IF_ERROR(last.Step().status());
    number = last.Integer(0) + 1;
  }
  MOTIONDB_RETURN_IF_ERROR(
      connection.InsertRow("tombstone",
                           "INSERT INTO tombstone (database_key, number, revision, clip, segment) "
                           "VALUES (?, ?, ?, ?, ?)",
                           clip.database_key, number, revision, clip.clip, segment));
  // Of the last deletions, exactly those that are still relevant stay.
  const std::int64_t last_removed = number - kTombstonesKept;
  std::optional<std::int64_t> removed;
  {
    Statement row = connection.Query(
        "SELECT revision FROM tombstone WHERE database_key = ? AND number <= ? "
        "ORDER BY number DESC LIMIT 1",
        clip.database_key, last_removed);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return absl::OkStatus();
    removed = row.Integer(0);
  }
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("DELETE FROM tombstone WHERE database_key = ? AND number <= ?", clip.database_key,
                 last_removed)
          .Run());
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE database SET removed_revision = ? WHERE database_key = ?", *removed,
                 clip.database_key)
          .Run());
  return connection.SetRowChecksum("database", clip.database_key);
}

}  // namespace

absl::StatusOr<std::int64_t> SelectRevision(Connection& connection, const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row =
      connection.Query("SELECT revision FROM database WHERE database_key = ?", database_key);
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  return row.Integer(0);
}

absl::StatusOr<std::int64_t> NextRevision(Connection& connection, std::int64_t database_key) {
  Statement row = connection.Query(
      "UPDATE database SET revision = revision + 1 WHERE database_key = ? RETURNING revision",
      database_key);
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  const std::int64_t revision = row.Integer(0);
  MOTIONDB_RETURN_IF_ERROR(row.Run());
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("database", database_key));
  return revision;
}

absl::Status BurySegment(Connection& connection, const ClipRef& clip, const std::string& segment,
                         std::int64_t revision) {
  MOTIONDB_RETURN_IF_ERROR(UnburySegment(connection, clip, segment));
  return InsertTombstone(connection, clip, segment, revision);
}

absl::Status UnburySegment(Connection& connection, const ClipRef& clip,
                           const std::string& segment) {
  return connection
      .Query("DELETE FROM tombstone WHERE database_key = ? AND clip = ? AND segment = ?",
             clip.database_key, clip.clip, segment)
      .Run();
}

absl::Status BuryClip(Connection& connection, const ClipRef& clip, std::int64_t revision) {
  MOTIONDB_RETURN_IF_ERROR(connection
                               .Query("DELETE FROM tombstone WHERE database_key = ? AND clip = ?",
                                      clip.database_key, clip.clip)
                               .Run());
  return InsertTombstone(connection, clip, "", revision);
}

absl::StatusOr<std::vector<ChangeRecord>> SelectChanges(Connection& connection,
                                                        const std::string& database,
                                                        std::int64_t after, int limit,
                                                        std::int64_t begun) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  {
    Statement row = connection.Query("SELECT removed_revision FROM database WHERE database_key = ?",
                                     database_key);
    MOTIONDB_RETURN_IF_ERROR(row.Step().status());
    MOTIONDB_RETURN_IF_ERROR(CheckRevision(after, begun, row.Integer(0)));
  }
  MOTIONDB_ASSIGN_OR_RETURN(const auto model, SelectModelRevision(connection, database_key, after));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t last,
                            RevisionOfLast(connection, database_key, after, limit, model));
  std::vector<ChangeRecord> changes;
  Statement tombstone = connection.Query(
      "SELECT revision, clip, segment FROM tombstone WHERE database_key = ? AND revision > ? AND "
      "revision <= ? ORDER BY revision, clip, segment",
      database_key, after, last);
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, tombstone.Step());
    if (!found) break;
    changes.push_back({tombstone.Integer(0), Deleted{tombstone.Text(1), tombstone.Text(2)}});
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto clips,
                            SelectChangedClips(connection, database_key, database, after, last));
  for (ClipRecord& clip : clips) {
    const std::int64_t revision = clip.revision;
    changes.push_back({revision, ClipPut{std::move(clip)}});
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto segments,
                            SelectChangedSegments(connection, database_key, database, after, last));
  for (SegmentRecord& segment : segments) {
    const std::int64_t revision = segment.revision;
    changes.push_back({revision, SegmentPut{std::move(segment)}});
  }
  if (model && model->revision <= last) changes.push_back({model->revision, model->put});
  // Stable: of one revision, deletions, clips, segments, the model.
  std::ranges::stable_sort(changes, {}, &ChangeRecord::revision);
  return changes;
}

}  // namespace motiondb::storage
