#include "storage/sqlite/clip_table.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/blob/crc32.h"
#include "storage/blob/states_codec.h"
#include "storage/sqlite/clip_bytes.h"
#include "storage/sqlite/database_table.h"
#include "storage/sqlite/enum_text.h"
#include "storage/sqlite/free_id.h"
#include "storage/sqlite/row_checksum.h"
#include "storage/sqlite/skeleton_table.h"

namespace motiondb::storage {
namespace {

// A deleted clip that no model needs.
constexpr char kRemoved[] =
    "deleted = 1 AND NOT EXISTS (SELECT 1 FROM model_clip WHERE model_clip.clip_key = "
    "clip.clip_key)";

// A query for clips as ToRecord reads them; `rest` follows the database in the condition.
std::string SelectWhere(std::string_view rest) {
  return fmt::format(
      "SELECT clip.id, label, subject, file_name, skeleton_file_name, format, frame_count, "
      "duration_seconds, source_frame_rate_hz, leg_length_m, ifnull(skeleton.id, ''), "
      "source_report, content_hash, create_time_us, "
      "ifnull(byte_count, 0) FROM clip LEFT JOIN skeleton "
      "USING (skeleton_key) WHERE clip.database_key = ? AND deleted = 0 AND {}",
      rest);
}

absl::StatusOr<ClipRecord> ToRecord(const std::string& database, const Statement& row) {
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
  return record;
}

std::string Place(const std::string& database, const std::string& clip) {
  return fmt::format("database '{}', clip '{}'", database, clip);
}

absl::Status NoClip(const std::string& database, const std::string& clip) {
  return core::NotFound("database '{}' has no clip '{}'", database, clip);
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

// The id that a new clip gets. ALREADY_EXISTS as AddClip says.
absl::StatusOr<std::string> ChooseId(Connection& connection, std::int64_t database_key,
                                     const NewClip& clip) {
  const ClipRecord& record = clip.record;
  Statement alike = connection.Query(
      "SELECT id FROM clip WHERE database_key = ? AND content_hash = ? AND deleted = 0",
      database_key, record.content_hash);
  MOTIONDB_ASSIGN_OR_RETURN(const bool stored, alike.Step());
  if (stored) {
    return absl::AlreadyExistsError(
        fmt::format("database '{}' holds the same motion already, as clip '{}'", record.database,
                    alike.Text(0)));
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      std::string free,
      FreeId(connection, "SELECT 1 FROM clip WHERE database_key = ? AND id = ? AND deleted = 0",
             database_key, record.id));
  if (clip.id_is_fixed && free != record.id) {
    return absl::AlreadyExistsError(
        fmt::format("database '{}' holds another clip '{}'", record.database, record.id));
  }
  return free;
}

absl::Status InsertRow(Connection& connection, std::int64_t database_key, std::int64_t skeleton_key,
                       const NewClip& clip, const std::string& id) {
  const ClipRecord& record = clip.record;
  const core::RootPath& path = clip.states.root_path;
  const auto path_bytes =
      std::as_bytes(std::span(path.data(), static_cast<std::size_t>(path.size())));
  Statement insert = connection.Query(
      "INSERT INTO clip (database_key, id, label, subject, file_name, skeleton_file_name, format, "
      "frame_count, duration_seconds, source_frame_rate_hz, leg_length_m, source_report, "
      "content_hash, root_path_crc, create_time_us, skeleton_key) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
      database_key, id, record.label, record.subject, record.file_name, record.skeleton_file_name,
      ToText(record.format), record.frame_count, record.duration_seconds,
      record.source_frame_rate_hz, record.leg_length_m, record.source_report, record.content_hash,
      Crc32(path_bytes), record.create_time_us);
  if (skeleton_key == 0) {
    insert.Bind(nullptr);
  } else {
    insert.Bind(skeleton_key);
  }
  return insert.Run();
}

absl::Status InsertBlobs(Connection& connection, const BlobOwner& owner, const NewClip& clip) {
  MOTIONDB_RETURN_IF_ERROR(WriteBlob(connection, owner, BlobKind::kMotionFile, clip.file_bytes));
  MOTIONDB_RETURN_IF_ERROR(
      WriteBlob(connection, owner, BlobKind::kSkeletonFile, clip.skeleton_bytes));
  return WriteBlob(connection, owner, BlobKind::kStates,
                   [&](ByteSink& sink) { return EncodeStates(clip.states, sink); });
}

}  // namespace

absl::StatusOr<ClipRecord> InsertClip(Connection& connection, const NewClip& clip) {
  if (clip.record.frame_count != clip.states.frame_count()) {
    return core::InvalidArgument("clip '{}': frame_count is {}, but there are {} states",
                                 clip.record.id, clip.record.frame_count,
                                 clip.states.frame_count());
  }
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key,
                            FindDatabase(connection, clip.record.database));
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ChooseId(connection, database_key, clip));
  if (clip.marker_set_text) {
    MOTIONDB_RETURN_IF_ERROR(SetMarkerSetText(connection, database_key, *clip.marker_set_text));
  }
  std::int64_t skeleton_key = 0;
  if (clip.skeleton) {
    MOTIONDB_ASSIGN_OR_RETURN(skeleton_key,
                              FindOrInsertSkeleton(connection, database_key, *clip.skeleton));
  }
  MOTIONDB_RETURN_IF_ERROR(InsertRow(connection, database_key, skeleton_key, clip, id));
  const std::int64_t key = connection.last_insert_key();
  MOTIONDB_RETURN_IF_ERROR(InsertBlobs(connection, ClipOwner(key), clip));
  MOTIONDB_RETURN_IF_ERROR(CountBytes(connection, key));
  return SelectClip(connection, clip.record.database, id);
}

absl::StatusOr<ClipRecord> SelectClip(Connection& connection, const std::string& database,
                                      const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectWhere("clip.id = ?"), database_key, clip);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoClip(database, clip);
  return ToRecord(database, row);
}

absl::StatusOr<std::vector<ClipRecord>> SelectClips(Connection& connection,
                                                    const std::string& database, const Page& page) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectWhere("clip.id > ? ORDER BY clip.id LIMIT ?"),
                                   database_key, page.after, page.limit);
  std::vector<ClipRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToRecord(database, row));
  }
}

absl::StatusOr<ClipSource> SelectClipSource(Connection& connection, const std::string& database,
                                            const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindClip(connection, database, clip));
  auto file = ReadBlob(connection, ClipOwner(key), BlobKind::kMotionFile);
  if (!file.ok()) return In(Place(database, clip), file.status());
  auto skeleton = ReadBlob(connection, ClipOwner(key), BlobKind::kSkeletonFile);
  if (!skeleton.ok()) return In(Place(database, clip), skeleton.status());
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
  if (!read.ok()) return In(Place(database, clip), read);
  return states;
}

absl::StatusOr<ClipRecord> RemoveClip(Connection& connection, const std::string& database,
                                      const std::string& clip, Remains remains) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindClip(connection, database, clip));
  MOTIONDB_ASSIGN_OR_RETURN(ClipRecord record, SelectClip(connection, database, clip));
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query("UPDATE clip SET deleted = 1, skeleton_key = NULL WHERE clip_key = ?", key)
          .Run());
  MOTIONDB_RETURN_IF_ERROR(SetRowChecksum(connection, "clip", key));
  if (remains == Remains::kFree) {
    MOTIONDB_RETURN_IF_ERROR(DeleteBlob(connection, ClipOwner(key), BlobKind::kMotionFile));
    MOTIONDB_RETURN_IF_ERROR(DeleteBlob(connection, ClipOwner(key), BlobKind::kSkeletonFile));
  }
  MOTIONDB_RETURN_IF_ERROR(DeleteUnusedSkeletons(connection, database_key));
  return record;
}

absl::Status PurgeRemovedClips(Connection& connection, std::int64_t database_key) {
  return connection
      .Query(fmt::format("DELETE FROM clip WHERE database_key = ? AND {}", kRemoved), database_key)
      .Run();
}

absl::Status PurgeRemovedClip(Connection& connection, std::int64_t clip_key) {
  return connection
      .Query(fmt::format("DELETE FROM clip WHERE clip_key = ? AND {}", kRemoved), clip_key)
      .Run();
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
  Statement row = connection.Query(
      "SELECT clip_key FROM clip WHERE database_key = ? AND id = ? AND deleted <= ? AND "
      "frame_count = ? AND root_path_crc = ? ORDER BY deleted LIMIT 1",
      database_key, clip.id, deleted == Deleted::kToo ? 1 : 0, clip.frame_count,
      Crc32(std::as_bytes(root_path)));
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) {
    return core::NotFound("the clip '{}' that the model was built from is not stored any more",
                          clip.id);
  }
  return row.Integer(0);
}

}  // namespace motiondb::storage
