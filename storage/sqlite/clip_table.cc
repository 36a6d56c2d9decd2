#include "storage/sqlite/clip_table.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"
#include "storage/blob/clip_codec.h"
#include "storage/sqlite/clip_bytes.h"
#include "storage/sqlite/database_table.h"
#include "storage/sqlite/enum_text.h"
#include "storage/sqlite/row_checksum.h"
#include "storage/sqlite/skeleton_table.h"

namespace motiondb::storage {
namespace {

// SQL condition: a deleted clip that no model uses.
constexpr char kRemoved[] =
    "deleted = 1 AND NOT EXISTS (SELECT 1 FROM model_clip WHERE model_clip.clip_key = "
    "clip.clip_key)";

// Returns a query for the columns that ToClipRecord reads. `rest` ends the WHERE clause.
std::string SelectClips(std::string_view rest) {
  return fmt::format(
      "SELECT clip.id, label, subject, file_name, skeleton_file_name, format, frame_count, "
      "duration_seconds, source_frame_rate_hz, leg_length_m, ifnull(skeleton.id, ''), "
      "source_report, content_hash, create_time_us, ifnull(byte_count, 0), "
      "representation_version, tried_version, tried_time_us, derive_error, "
      "given_metres_per_unit, given_up_axis, given_frame_rate_hz, given_leg_length_m, given_take "
      "FROM clip LEFT JOIN skeleton USING (skeleton_key) "
      "WHERE clip.database_key = ? AND deleted = 0 AND {}",
      rest);
}

std::optional<double> OptionalReal(const Statement& row, int column) {
  return row.IsNull(column) ? std::nullopt : std::optional(row.Real(column));
}

absl::StatusOr<ClipRecord> ToClipRecord(const std::string& database, const Statement& row) {
  ClipRecord record;
  record.database = database;
  record.id = row.Text(0);
  record.label = row.Text(1);
  record.subject = row.Text(2);
  record.file_name = row.Text(3);
  record.skeleton_file_name = row.Text(4);
  MOTIONDB_ASSIGN_OR_RETURN(record.format, FromText<core::FileFormat>(row.Text(5)));
  record.frame_count = row.Integer<std::int32_t>(6);
  record.duration_seconds = row.Real(7);
  record.source_frame_rate_hz = row.Real(8);
  record.leg_length_m = row.Real(9);
  record.skeleton_id = row.Text(10);
  record.source_report = row.Text(11);
  record.content_hash = row.Integer<std::uint64_t>(12);
  record.create_time_us = row.Integer(13);
  record.byte_count = row.Integer(14);
  record.representation_version = row.Integer<std::int32_t>(15);
  record.tried_version = row.Integer<std::int32_t>(16);
  record.tried_time_us = row.Integer(17);
  record.derive_error = row.Text(18);
  record.given.metres_per_unit = OptionalReal(row, 19);
  if (!row.IsNull(20)) {
    MOTIONDB_ASSIGN_OR_RETURN(record.given.up_axis, FromText<core::UpAxis>(row.Text(20)));
  }
  record.given.frame_rate_hz = OptionalReal(row, 21);
  record.given_leg_length_m = OptionalReal(row, 22);
  record.given.take = row.Text(23);
  return record;
}

std::string DescribeClip(const std::string& database, const std::string& clip) {
  return fmt::format("database '{}', clip '{}'", database, clip);
}

absl::Status NoClip(const std::string& database, const std::string& clip) {
  return core::WithReason("CLIP_NOT_FOUND",
                          core::NotFound("database '{}' has no clip '{}'", database, clip));
}

absl::StatusOr<std::int64_t> FindClip(Connection& connection, const std::string& database,
                                      const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(
      "SELECT clip_key FROM clip WHERE database_key = ? AND id = ? AND deleted = 0", database_key,
      clip);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoClip(database, clip);
  return row.Integer(0);
}

// Returns the skeleton key of a clip; 0 if it has none.
absl::StatusOr<std::int64_t> SkeletonOf(Connection& connection, std::int64_t clip_key) {
  Statement row =
      connection.Query("SELECT ifnull(skeleton_key, 0) FROM clip WHERE clip_key = ?", clip_key);
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

// Inserts a row; `skeleton_key` 0: no skeleton.
absl::Status InsertRow(Connection& connection, std::int64_t database_key, std::int64_t skeleton_key,
                       const ClipRecord& record, const core::RootPath& path) {
  const auto path_bytes =
      std::as_bytes(std::span(path.data(), static_cast<std::size_t>(path.size())));
  const auto& up = record.given.up_axis;
  return connection
      .Query(
          "INSERT INTO clip (database_key, id, label, subject, file_name, skeleton_file_name, "
          "format, frame_count, duration_seconds, source_frame_rate_hz, leg_length_m, "
          "source_report, content_hash, root_path_crc, create_time_us, skeleton_key, "
          "representation_version, tried_version, tried_time_us, derive_error, "
          "given_metres_per_unit, given_up_axis, given_frame_rate_hz, given_leg_length_m, "
          "given_take) "
          "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, "
          "?, ?)",
          database_key, record.id, record.label, record.subject, record.file_name,
          record.skeleton_file_name, ToText(record.format), record.frame_count,
          record.duration_seconds, record.source_frame_rate_hz, record.leg_length_m,
          record.source_report, record.content_hash, Crc32(path_bytes), record.create_time_us,
          skeleton_key, record.representation_version, record.tried_version, record.tried_time_us,
          record.derive_error, record.given.metres_per_unit,
          up ? std::optional<std::string>(ToText(*up)) : std::nullopt, record.given.frame_rate_hz,
          record.given_leg_length_m, record.given.take)
      .Run();
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
  return SetRowChecksum(connection, "clip", clip_key);
}

// Replaces a row by a new one with `states`, and moves the files and the skeleton to it. The old
// row is marked as deleted and gets representation_version 0, so that a model that uses it is not
// extended.
absl::Status ReplaceRow(Connection& connection, std::int64_t database_key, std::int64_t clip_key,
                        const ClipRecord& record, const core::StateSequence& states) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t skeleton_key, SkeletonOf(connection, clip_key));
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE clip SET representation_version = 0 WHERE clip_key = ?", clip_key)
          .Run());
  MOTIONDB_RETURN_IF_ERROR(MarkDeleted(connection, clip_key));
  MOTIONDB_RETURN_IF_ERROR(
      InsertRow(connection, database_key, skeleton_key, record, states.root_path));
  const std::int64_t key = connection.last_insert_key();
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip_chunk SET clip_key = ? WHERE clip_key = ? AND kind IN (?, ?)", key,
                 clip_key, static_cast<int>(BlobKind::kMotionFile),
                 static_cast<int>(BlobKind::kSkeletonFile))
          .Run());
  MOTIONDB_RETURN_IF_ERROR(WriteStates(connection, key, states));
  return UpdateByteCount(connection, key);
}

absl::Status UpdateRow(Connection& connection, std::int64_t clip_key, const ClipRecord& record) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET source_report = ?, representation_version = ?, "
                 "tried_version = ?, tried_time_us = ?, derive_error = ? WHERE clip_key = ?",
                 record.source_report, record.representation_version, record.tried_version,
                 record.tried_time_us, record.derive_error, clip_key)
          .Run());
  return SetRowChecksum(connection, "clip", clip_key);
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
  MOTIONDB_RETURN_IF_ERROR(CheckFrameCount(clip.record, clip.states));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key,
                            FindDatabase(connection, clip.record.database));
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
  MOTIONDB_RETURN_IF_ERROR(
      InsertRow(connection, database_key, skeleton_key, record, clip.states.root_path));
  const std::int64_t key = connection.last_insert_key();
  MOTIONDB_RETURN_IF_ERROR(InsertBlobs(connection, ClipOwner(key), clip));
  MOTIONDB_RETURN_IF_ERROR(UpdateByteCount(connection, key));
  return SelectClip(connection, record.database, record.id);
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
                            FindDatabase(connection, before.database));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindListed(connection, database_key, before));
  if (key == 0) {
    return absl::AbortedError(fmt::format("{} was deleted or replaced by another call: try again",
                                          DescribeClip(before.database, before.id)));
  }
  // So that no model that uses it gets a second clip of this id. RemoveClip updates row_crc.
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE clip SET representation_version = 0 WHERE clip_key = ?", key).Run());
  MOTIONDB_RETURN_IF_ERROR(RemoveClip(connection, before.database, before.id, remains).status());
  return InsertClip(connection, clip);
}

absl::StatusOr<std::vector<ClipRecord>> PutDerivedClips(Connection& connection,
                                                        const std::string& database,
                                                        std::span<const DerivedClip> clips) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  std::vector<ClipRecord> stored;
  for (const DerivedClip& clip : clips) {
    if (clip.states) MOTIONDB_RETURN_IF_ERROR(CheckFrameCount(clip.record, *clip.states));
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key,
                              FindListed(connection, database_key, clip.record));
    if (key == 0) continue;
    MOTIONDB_RETURN_IF_ERROR(
        clip.states ? ReplaceRow(connection, database_key, key, clip.record, *clip.states)
                    : UpdateRow(connection, key, clip.record));
    MOTIONDB_ASSIGN_OR_RETURN(stored.emplace_back(),
                              SelectClip(connection, database, clip.record.id));
  }
  return stored;
}

absl::StatusOr<ClipRecord> SelectClip(Connection& connection, const std::string& database,
                                      const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectClips("clip.id = ?"), database_key, clip);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoClip(database, clip);
  return ToClipRecord(database, row);
}

absl::StatusOr<std::vector<ClipRecord>> SelectClips(Connection& connection,
                                                    const std::string& database, const Page& page) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectClips("clip.id > ? ORDER BY clip.id LIMIT ?"),
                                   database_key, page.after, page.limit);
  std::vector<ClipRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToClipRecord(database, row));
  }
}

absl::StatusOr<ClipSource> SelectClipSource(Connection& connection, const std::string& database,
                                            const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindClip(connection, database, clip));
  auto file = ReadBlob(connection, ClipOwner(key), BlobKind::kMotionFile);
  if (!file.ok()) return In(DescribeClip(database, clip), file.status());
  auto skeleton = ReadBlob(connection, ClipOwner(key), BlobKind::kSkeletonFile);
  if (!skeleton.ok()) return In(DescribeClip(database, clip), skeleton.status());
  return ClipSource{*std::move(file), *std::move(skeleton)};
}

absl::StatusOr<core::StateSequence> SelectClipStates(Connection& connection,
                                                     const std::string& database,
                                                     const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindClip(connection, database, clip));
  core::StateSequence states;
  const absl::Status read = ReadBlob(connection, ClipOwner(key), BlobKind::kStates,
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
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindClip(connection, database, clip));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t skeleton_key, SkeletonOf(connection, key));
  MOTIONDB_RETURN_IF_ERROR(MarkDeleted(connection, key));
  if (remains == FreePolicy::kFree) {
    MOTIONDB_RETURN_IF_ERROR(DeleteBlob(connection, ClipOwner(key), BlobKind::kMotionFile));
    MOTIONDB_RETURN_IF_ERROR(DeleteBlob(connection, ClipOwner(key), BlobKind::kSkeletonFile));
  }
  MOTIONDB_RETURN_IF_ERROR(DeleteUnusedSkeleton(connection, skeleton_key));
  return record;
}

absl::Status PurgeRemovedClips(Connection& connection, std::span<const std::int64_t> clip_keys) {
  for (const std::int64_t key : clip_keys) {
    MOTIONDB_RETURN_IF_ERROR(
        connection.Query(fmt::format("DELETE FROM clip WHERE clip_key = ? AND {}", kRemoved), key)
            .Run());
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

absl::StatusOr<std::int64_t> FindModelClip(Connection& connection, std::int64_t database_key,
                                           const core::ModelClip& clip,
                                           std::span<const double> root_path, Deleted deleted) {
  const std::uint32_t crc = Crc32(std::as_bytes(root_path));
  // Two queries with constant `deleted`: with a parameter SQLite would not use the partial indices.
  // The newest row: a clip whose states were replaced and that was then deleted has several rows.
  for (const char* const condition : {"deleted = 0", "deleted = 1"}) {
    Statement row = connection.Query(
        fmt::format("SELECT clip_key FROM clip WHERE database_key = ? AND id = ? AND {} AND "
                    "frame_count = ? AND root_path_crc = ? AND leg_length_m = ? AND label = ? "
                    "ORDER BY clip_key DESC LIMIT 1",
                    condition),
        database_key, clip.id, clip.frame_count, crc, clip.leg_length_m, clip.label);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) return row.Integer(0);
    if (deleted == Deleted::kNot) break;
  }
  return core::NotFound("the clip '{}' that the model was built from is no longer stored", clip.id);
}

}  // namespace motiondb::storage
