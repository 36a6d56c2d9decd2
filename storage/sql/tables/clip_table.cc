#include "storage/sql/tables/clip_table.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"
#include "storage/blob/clip_codec.h"
#include "storage/clip_segments.h"
#include "storage/sql/tables/change_feed.h"
#include "storage/sql/tables/clip_row.h"
#include "storage/sql/tables/clip_text.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/operation_table.h"
#include "storage/sql/tables/segment_table.h"
#include "storage/sql/tables/skeleton_table.h"

namespace motiondb::storage {
namespace {

// SQL condition: a deleted clip that no model uses.
constexpr char kRemoved[] =
    "deleted = 1 AND NOT EXISTS (SELECT 1 FROM model_clip WHERE model_clip.clip_key = "
    "clip.clip_key)";

// Returns the skeleton key of a clip; 0 if it has none.
absl::StatusOr<std::int64_t> SkeletonOf(Connection& connection, std::int64_t clip_key) {
  Statement row =
      connection.Query("SELECT COALESCE(skeleton_key, 0) FROM clip WHERE clip_key = ?", clip_key);
  MOTIONDB_RETURN_IF_ERROR(row.Step().status());
  return row.Integer(0);
}

// Returns the id of the clip of which MotionStore::FindSameClip returns the record; empty: none.
absl::StatusOr<std::string> IdOfSameClip(Connection& connection, std::int64_t database_key,
                                         const NewClip& clip) {
  Statement alike = connection.Query(
      "SELECT id FROM clip WHERE database_key = ? AND content_hash = ? AND deleted = 0",
      database_key, clip.record.content_hash);
  MOTIONDB_ASSIGN_OR_RETURN(const bool has_same_motion, alike.Step());
  if (has_same_motion) return alike.Text(0);
  if (!clip.id_is_fixed) return std::string();
  Statement named =
      connection.Query("SELECT id FROM clip WHERE database_key = ? AND id = ? AND deleted = 0",
                       database_key, clip.record.id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool has_same_id, named.Step());
  return has_same_id ? named.Text(0) : std::string();
}

// Returns the id for a new clip. ALREADY_EXISTS: see MotionStore::AddClip.
absl::StatusOr<std::string> ChooseId(Connection& connection, std::int64_t database_key,
                                     const NewClip& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string same, IdOfSameClip(connection, database_key, clip));
  if (!same.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(const ClipRecord record,
                              SelectClip(connection, clip.record.database, same));
    return SameClipError(record, clip);
  }
  return ChooseFreeId(connection,
                      "SELECT 1 FROM clip WHERE database_key = ? AND id = ? AND deleted = 0",
                      database_key, clip.record.id);
}

absl::Status WriteStates(Connection& connection, std::int64_t clip_key,
                         const core::StateSequence& states) {
  return WriteBlob(connection, ClipOwner(clip_key), BlobKind::kStates,
                   [&](ByteSink& sink) { return EncodeStates(states, sink); });
}

absl::Status InsertBlobs(Connection& connection, const BlobOwner& owner, const NewClip& clip) {
  MOTIONDB_RETURN_IF_ERROR(WriteBlob(connection, owner, BlobKind::kMotionFile, clip.file_bytes));
  MOTIONDB_RETURN_IF_ERROR(
      WriteBlob(connection, owner, BlobKind::kSkeletonFile, clip.skeleton_bytes));
  return WriteStates(connection, owner.key, clip.states);
}

absl::Status CheckFrameCount(const ClipRecord& record, const core::StateSequence& states) {
  if (record.frame_count == states.frame_count()) return absl::OkStatus();
  return core::InvalidArgument("clip '{}': expected {} states (frame_count), got {}", record.id,
                               record.frame_count, states.frame_count());
}

// Marks a clip as deleted. Its id, content hash and skeleton become free; its states stay.
absl::Status MarkDeleted(Connection& connection, std::int64_t clip_key) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET deleted = 1, skeleton_key = NULL WHERE clip_key = ?", clip_key)
          .Run());
  return connection.SetRowChecksum("clip", clip_key);
}

// Stores the segments and the searched text of a new row of a clip. `former`: the segments of the
// row before; those that are gone get a tombstone.
absl::Status InsertAnnotations(Connection& connection, const ClipRef& clip,
                               const ClipRecord& record, const std::vector<SegmentRecord>& segments,
                               const std::vector<SegmentRecord>& former) {
  MOTIONDB_RETURN_IF_ERROR(InsertSegments(connection, clip, segments));
  for (const SegmentRecord& segment : former) {
    const bool stays =
        std::ranges::find(segments, segment.id, &SegmentRecord::id) != segments.end();
    if (stays || segment.clip != record.id) continue;
    MOTIONDB_RETURN_IF_ERROR(BurySegment(connection, clip, segment.id, record.revision));
  }
  for (const SegmentRecord& segment : segments) {
    if (former.empty() || segment.revision != record.revision) continue;
    MOTIONDB_RETURN_IF_ERROR(UnburySegment(connection, clip, segment.id));
  }
  return InsertClipText(connection, clip.clip_key, TextOf(record, segments));
}

// Replaces a row by a new one with `states`, and moves the files and the skeleton to it. The old
// row is marked as deleted and gets representation_version 0, so that a model that uses it is not
// extended; it keeps its segments for that model.
absl::Status ReplaceRow(Connection& connection, const ClipRef& old, const ClipRecord& record,
                        const core::StateSequence& states, const ChangeStamp& stamp) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t skeleton_key, SkeletonOf(connection, old.clip_key));
  MOTIONDB_ASSIGN_OR_RETURN(const auto former, SelectSegments(connection, old));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET representation_version = 0 WHERE clip_key = ?", old.clip_key)
          .Run());
  MOTIONDB_RETURN_IF_ERROR(MarkDeleted(connection, old.clip_key));
  MOTIONDB_RETURN_IF_ERROR(DeleteClipText(connection, old.clip_key));
  ClipRef ref = old;
  MOTIONDB_ASSIGN_OR_RETURN(ref.clip_key, InsertClipRow(connection, old.database_key, skeleton_key,
                                                        record, states.root_path));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip_chunk SET clip_key = ? WHERE clip_key = ? AND kind IN (?, ?)",
                 ref.clip_key, old.clip_key, static_cast<int>(BlobKind::kMotionFile),
                 static_cast<int>(BlobKind::kSkeletonFile))
          .Run());
  MOTIONDB_RETURN_IF_ERROR(WriteStates(connection, ref.clip_key, states));
  MOTIONDB_RETURN_IF_ERROR(UpdateByteCount(connection, ref.clip_key));
  std::vector<SegmentRecord> segments = former;
  AdaptToClip(record, stamp, segments);
  return InsertAnnotations(connection, ref, record, segments, former);
}

// Deletes a clip, but not its segments. See RemoveClip.
absl::Status TakeAway(Connection& connection, std::int64_t clip_key, FreePolicy remains) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t skeleton_key, SkeletonOf(connection, clip_key));
  MOTIONDB_RETURN_IF_ERROR(MarkDeleted(connection, clip_key));
  if (remains == FreePolicy::kFree) {
    const BlobOwner owner = ClipOwner(clip_key);
    MOTIONDB_RETURN_IF_ERROR(DeleteBlob(connection, owner, BlobKind::kMotionFile));
    MOTIONDB_RETURN_IF_ERROR(DeleteBlob(connection, owner, BlobKind::kSkeletonFile));
    MOTIONDB_RETURN_IF_ERROR(DeleteClipText(connection, clip_key));
  }
  return DeleteUnusedSkeleton(connection, skeleton_key);
}

// Adds a clip in place of one with the segments `former`, or as a new one.
absl::StatusOr<ClipRecord> InsertAfter(Connection& connection, const NewClip& clip,
                                       const std::vector<SegmentRecord>& former) {
  MOTIONDB_RETURN_IF_ERROR(CheckFrameCount(clip.record, clip.states));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key,
                            FindDatabase(connection, clip.record.database, clip.database_id));
  ClipRecord record = clip.record;
  MOTIONDB_ASSIGN_OR_RETURN(record.id, ChooseId(connection, database_key, clip));
  if (clip.marker_set_text) {
    MOTIONDB_RETURN_IF_ERROR(SetMarkerSetText(connection, database_key, *clip.marker_set_text));
  }
  std::int64_t skeleton_key = 0;
  if (clip.skeleton) {
    MOTIONDB_ASSIGN_OR_RETURN(skeleton_key,
                              FindOrInsertSkeleton(connection, database_key, *clip.skeleton));
  }
  MOTIONDB_ASSIGN_OR_RETURN(record.revision, NextRevision(connection, database_key));
  const ChangeStamp stamp{clip.author, record.create_time_us, record.revision};
  MOTIONDB_ASSIGN_OR_RETURN(const auto segments, SegmentsOf(clip, record, former, stamp));
  ClipRef ref{database_key, 0, record.database, record.id};
  MOTIONDB_ASSIGN_OR_RETURN(ref.clip_key, InsertClipRow(connection, database_key, skeleton_key,
                                                        record, clip.states.root_path));
  MOTIONDB_RETURN_IF_ERROR(InsertBlobs(connection, ClipOwner(ref.clip_key), clip));
  MOTIONDB_RETURN_IF_ERROR(UpdateByteCount(connection, ref.clip_key));
  MOTIONDB_RETURN_IF_ERROR(InsertAnnotations(connection, ref, record, segments, former));
  return SelectClip(connection, record.database, record.id);
}

// Returns the key of the clip that was listed as `record`; 0 if it no longer exists.
absl::StatusOr<std::int64_t> FindListed(Connection& connection, std::int64_t database_key,
                                        const ClipRecord& record) {
  Statement row = connection.Query(
      "SELECT clip_key FROM clip WHERE database_key = ? AND id = ? AND deleted = 0 AND "
      "content_hash = ? AND create_time_us = ?",
      database_key, record.id, record.content_hash, record.create_time_us);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? row.Integer(0) : 0;
}

}  // namespace

absl::StatusOr<ClipRecord> InsertClip(Connection& connection, const NewClip& clip) {
  return InsertAfter(connection, clip, {});
}

absl::StatusOr<ClipRecord> SelectSameClip(Connection& connection, const NewClip& clip) {
  const std::string& database = clip.record.database;
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, IdOfSameClip(connection, database_key, clip));
  if (id.empty()) return NoClip(database, clip.record.id);
  return SelectClip(connection, database, id);
}

absl::StatusOr<ClipRecord> ReplaceClip(Connection& connection, const ClipRecord& before,
                                       const NewClip& clip, FreePolicy remains) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key,
                            FindDatabase(connection, before.database, clip.database_id));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindListed(connection, database_key, before));
  if (key == 0) {
    return absl::AbortedError(fmt::format("{} was deleted or replaced by another call: try again",
                                          DescribeClip(before.database, before.id)));
  }
  const ClipRef ref{database_key, key, before.database, before.id};
  MOTIONDB_ASSIGN_OR_RETURN(const ClipRecord old,
                            SelectClip(connection, before.database, before.id));
  MOTIONDB_ASSIGN_OR_RETURN(const auto segments, SelectSegments(connection, ref));
  // So that no model that uses it gets a second clip of this id. TakeAway updates row_crc.
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE clip SET representation_version = 0 WHERE clip_key = ?", key).Run());
  MOTIONDB_RETURN_IF_ERROR(TakeAway(connection, key, remains));
  NewClip next = clip;
  KeepAnnotations(old, next.record);
  MOTIONDB_ASSIGN_OR_RETURN(ClipRecord added, InsertAfter(connection, next, segments));
  if (added.id != before.id) {
    MOTIONDB_RETURN_IF_ERROR(BuryClip(connection, ref, added.revision));
  }
  return added;
}

absl::StatusOr<std::vector<ClipRecord>> PutDerivedClips(Connection& connection,
                                                        const std::string& database,
                                                        std::span<const DerivedClip> clips,
                                                        std::int64_t fence) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_RETURN_IF_ERROR(CheckFence(connection, database_key, fence));
  std::vector<ClipRecord> stored;
  ChangeStamp stamp;
  for (const DerivedClip& clip : clips) {
    if (clip.states) MOTIONDB_RETURN_IF_ERROR(CheckFrameCount(clip.record, *clip.states));
    const std::string& id = clip.record.id;
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key,
                              FindListed(connection, database_key, clip.record));
    if (key == 0) continue;
    if (stamp.revision == 0) {
      MOTIONDB_ASSIGN_OR_RETURN(stamp.revision, NextRevision(connection, database_key));
    }
    stamp.time_us = clip.record.tried_time_us;
    // The clip can have been edited since it was listed.
    MOTIONDB_ASSIGN_OR_RETURN(const ClipRecord now, SelectClip(connection, database, id));
    ClipRecord record = clip.record;
    CopyAnnotations(now, record);
    record.revision = stamp.revision;
    const ClipRef ref{database_key, key, database, id};
    MOTIONDB_RETURN_IF_ERROR(clip.states ? ReplaceRow(connection, ref, record, *clip.states, stamp)
                                         : UpdateDerivation(connection, key, record));
    MOTIONDB_ASSIGN_OR_RETURN(stored.emplace_back(), SelectClip(connection, database, id));
  }
  return stored;
}

absl::StatusOr<ClipSource> SelectClipSource(Connection& connection, const std::string& database,
                                            const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const ClipRef ref, FindClip(connection, database, clip));
  const BlobOwner owner = ClipOwner(ref.clip_key);
  auto file = ReadBlob(connection, owner, BlobKind::kMotionFile);
  if (!file.ok()) return In(DescribeClip(database, clip), file.status());
  auto skeleton = ReadBlob(connection, owner, BlobKind::kSkeletonFile);
  if (!skeleton.ok()) return In(DescribeClip(database, clip), skeleton.status());
  return ClipSource{*std::move(file), *std::move(skeleton)};
}

absl::StatusOr<core::StateSequence> SelectClipStates(Connection& connection,
                                                     const std::string& database,
                                                     const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const ClipRef ref, FindClip(connection, database, clip));
  core::StateSequence states;
  const absl::Status read = ReadBlob(connection, ClipOwner(ref.clip_key), BlobKind::kStates,
                                     [&](ByteSource& source) -> absl::Status {
                                       MOTIONDB_ASSIGN_OR_RETURN(states, DecodeStates(source));
                                       return absl::OkStatus();
                                     });
  if (!read.ok()) return In(DescribeClip(database, clip), read);
  return states;
}

absl::StatusOr<ClipRecord> RemoveClip(Connection& connection, const std::string& database,
                                      const std::string& clip, FreePolicy remains) {
  MOTIONDB_ASSIGN_OR_RETURN(ClipRecord record, SelectClip(connection, database, clip));
  MOTIONDB_ASSIGN_OR_RETURN(const ClipRef ref, FindClip(connection, database, clip));
  MOTIONDB_RETURN_IF_ERROR(TakeAway(connection, ref.clip_key, remains));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision,
                            NextRevision(connection, ref.database_key));
  MOTIONDB_RETURN_IF_ERROR(BuryClip(connection, ref, revision));
  return record;
}

absl::Status PurgeRemovedClips(Connection& connection, std::span<const std::int64_t> clip_keys) {
  for (const std::int64_t key : clip_keys) {
    MOTIONDB_RETURN_IF_ERROR(
        connection.Query(fmt::format("DELETE FROM clip WHERE clip_key = ? AND {}", kRemoved), key)
            .Run());
    // Usually gone since the clip was deleted.
    if (connection.changes() > 0) MOTIONDB_RETURN_IF_ERROR(DeleteClipText(connection, key));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::int64_t>> SelectRemovedClips(Connection& connection,
                                                             const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(
      fmt::format("SELECT clip_key FROM clip WHERE database_key = ? AND {} ORDER BY clip_key",
                  kRemoved),
      database_key);
  std::vector<std::int64_t> keys;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return keys;
    keys.push_back(row.Integer(0));
  }
}

}  // namespace motiondb::storage
