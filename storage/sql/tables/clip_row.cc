#include "storage/sql/tables/clip_row.h"

#include <optional>
#include <span>
#include <string_view>

#include "core/motion/error.h"
#include "storage/blob/annotation_codec.h"
#include "storage/blob/checksums.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/enum_text.h"
#include "storage/sql/tables/segment_table.h"

namespace motiondb::storage {
namespace {

// Returns a query for the columns that ToClipRecord reads. `rest` ends the WHERE clause.
std::string SelectClipColumns(std::string_view rest) {
  return fmt::format(
      "SELECT clip.id, {}, subject, file_name, skeleton_file_name, format, frame_count, "
      "duration_seconds, source_frame_rate_hz, leg_length_m, COALESCE(skeleton.id, ''), "
      "source_report, content_hash, create_time_us, COALESCE(byte_count, 0), "
      "representation_version, tried_version, tried_time_us, derive_error, "
      "given_metres_per_unit, given_up_axis, given_frame_rate_hz, given_leg_length_m, given_take, "
      "title, description, annotations, clip.revision, edit_time_us "
      "FROM clip LEFT JOIN skeleton USING (skeleton_key) "
      "WHERE clip.database_key = ? AND deleted = 0 AND {}",
      kLabelColumn, rest);
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
  record.title = row.Text(24);
  record.description = row.Text(25);
  if (!row.IsNull(26)) {
    MOTIONDB_RETURN_IF_ERROR(
        In(fmt::format("{}: tags and fields", DescribeClip(database, record.id)),
           DecodeAnnotations(row.Blob(26), record)));
  }
  record.revision = row.Integer(27);
  record.edit_time_us = row.Integer(28);
  return record;
}

absl::StatusOr<std::vector<ClipRecord>> ReadClips(Statement row, const std::string& database) {
  std::vector<ClipRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToClipRecord(database, row));
  }
}

// Returns the column `annotations`: none if the clip has no tags and no fields.
absl::StatusOr<std::optional<std::string>> EncodedAnnotations(const ClipRecord& record) {
  if (record.tags.empty() && record.fields.empty()) return std::optional<std::string>();
  MOTIONDB_ASSIGN_OR_RETURN(std::string bytes, EncodeAnnotations(record));
  return std::optional(std::move(bytes));
}

std::optional<std::span<const std::byte>> AsBlob(const std::optional<std::string>& bytes) {
  if (!bytes) return std::nullopt;
  return std::as_bytes(std::span(*bytes));
}

}  // namespace

std::string DescribeClip(const std::string& database, const std::string& clip) {
  return fmt::format("database '{}', clip '{}'", database, clip);
}

absl::Status NoClip(const std::string& database, const std::string& clip) {
  return core::WithReason("CLIP_NOT_FOUND",
                          core::NotFound("database '{}' has no clip '{}'", database, clip));
}

absl::StatusOr<ClipRef> FindClip(Connection& connection, const std::string& database,
                                 const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(
      "SELECT clip_key FROM clip WHERE database_key = ? AND id = ? AND deleted = 0", database_key,
      clip);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoClip(database, clip);
  return ClipRef{database_key, row.Integer(0), database, clip};
}

absl::StatusOr<ClipRecord> SelectClip(Connection& connection, const std::string& database,
                                      const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  Statement row = connection.Query(SelectClipColumns("clip.id = ?"), database_key, clip);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoClip(database, clip);
  return ToClipRecord(database, row);
}

absl::StatusOr<std::vector<ClipRecord>> SelectClips(Connection& connection,
                                                    const std::string& database, const Page& page) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  return ReadClips(connection.Query(SelectClipColumns("clip.id > ? ORDER BY clip.id LIMIT ?"),
                                    database_key, page.after, page.limit),
                   database);
}

absl::StatusOr<std::vector<ClipRecord>> SelectChangedClips(Connection& connection,
                                                           std::int64_t database_key,
                                                           const std::string& database,
                                                           std::int64_t after, std::int64_t last) {
  return ReadClips(
      connection.Query(SelectClipColumns("clip.revision > ? AND clip.revision <= ? ORDER BY "
                                         "clip.revision, clip.id"),
                       database_key, after, last),
      database);
}

absl::StatusOr<std::int64_t> InsertClipRow(Connection& connection, std::int64_t database_key,
                                           std::int64_t skeleton_key, const ClipRecord& record,
                                           const core::RootPath& path) {
  const auto path_bytes =
      std::as_bytes(std::span(path.data(), static_cast<std::size_t>(path.size())));
  const auto& up = record.given.up_axis;
  MOTIONDB_ASSIGN_OR_RETURN(const auto annotations, EncodedAnnotations(record));
  return connection.Insert(
      "clip_key",
      "INSERT INTO clip (database_key, id, subject, file_name, skeleton_file_name, "
      "format, frame_count, duration_seconds, source_frame_rate_hz, leg_length_m, "
      "source_report, content_hash, root_path_crc, create_time_us, skeleton_key, "
      "representation_version, tried_version, tried_time_us, derive_error, "
      "given_metres_per_unit, given_up_axis, given_frame_rate_hz, given_leg_length_m, "
      "given_take, title, description, annotations, revision, edit_time_us) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, nullif(?, 0), ?, ?, ?, ?, ?, ?, ?, "
      "?, ?, ?, ?, ?, ?, ?)",
      database_key, record.id, record.subject, record.file_name, record.skeleton_file_name,
      ToText(record.format), record.frame_count, record.duration_seconds,
      record.source_frame_rate_hz, record.leg_length_m, record.source_report, record.content_hash,
      Crc32(path_bytes), record.create_time_us, skeleton_key, record.representation_version,
      record.tried_version, record.tried_time_us, record.derive_error, record.given.metres_per_unit,
      up ? std::optional<std::string>(ToText(*up)) : std::nullopt, record.given.frame_rate_hz,
      record.given_leg_length_m, record.given.take, record.title, record.description,
      AsBlob(annotations), record.revision, record.edit_time_us);
}

absl::Status UpdateDerivation(Connection& connection, std::int64_t clip_key,
                              const ClipRecord& record) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET source_report = ?, representation_version = ?, "
                 "tried_version = ?, tried_time_us = ?, derive_error = ?, revision = ? "
                 "WHERE clip_key = ?",
                 record.source_report, record.representation_version, record.tried_version,
                 record.tried_time_us, record.derive_error, record.revision, clip_key)
          .Run());
  return connection.SetRowChecksum("clip", clip_key);
}

absl::Status UpdateAnnotations(Connection& connection, std::int64_t clip_key,
                               const ClipRecord& record) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto annotations, EncodedAnnotations(record));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET subject = ?, title = ?, description = ?, annotations = ?, "
                 "revision = ?, edit_time_us = ? WHERE clip_key = ?",
                 record.subject, record.title, record.description, AsBlob(annotations),
                 record.revision, record.edit_time_us, clip_key)
          .Run());
  return connection.SetRowChecksum("clip", clip_key);
}

namespace {

constexpr int kBatch = 1000;

absl::StatusOr<std::vector<std::int64_t>> NextUncounted(Connection& connection,
                                                        std::int64_t after) {
  Statement row = connection.Query(
      "SELECT clip_key FROM clip WHERE byte_count IS NULL AND deleted = 0 AND clip_key > ? "
      "ORDER BY clip_key LIMIT ?",
      after, kBatch);
  std::vector<std::int64_t> keys;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return keys;
    keys.push_back(row.Integer(0));
  }
}

absl::Status CountEach(Connection& connection, const std::vector<std::int64_t>& keys) {
  return InTransaction(connection, Transaction::Kind::kWrite, [&](Connection&) -> absl::Status {
    for (const std::int64_t key : keys) MOTIONDB_RETURN_IF_ERROR(UpdateByteCount(connection, key));
    return absl::OkStatus();
  });
}

}  // namespace

absl::Status UpdateByteCount(Connection& connection, std::int64_t clip_key) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE clip SET byte_count = (SELECT COALESCE(sum(length(chunk)), 0) FROM "
                 "clip_chunk "
                 "WHERE clip_chunk.clip_key = clip.clip_key) WHERE clip_key = ?",
                 clip_key)
          .RunLater());
  return connection.SetRowChecksum("clip", clip_key);
}

void FillMissingByteCounts(Connection& connection) {
  for (std::int64_t last = 0;;) {
    const auto keys = NextUncounted(connection, last);
    if (!keys.ok() || keys->empty()) return;
    last = keys->back();
    const absl::Status counted = CountEach(connection, *keys);
    if (counted.ok()) continue;
    if (!absl::IsDataLoss(counted)) return;
    // After DATA_LOSS the transaction cannot continue: count each clip in its own transaction.
    for (const std::int64_t key : *keys) {
      if (!absl::IsDataLoss(CountEach(connection, {key}))) continue;
      InTransaction(connection, Transaction::Kind::kWrite, [&](Connection&) -> absl::Status {
        MOTIONDB_RETURN_IF_ERROR(
            connection.Query("UPDATE clip SET byte_count = 0 WHERE clip_key = ?", key).Run());
        return connection.SetRowChecksum("clip", key);
      }).IgnoreError();
    }
  }
}

}  // namespace motiondb::storage
