#include "storage/sql/sql_verifier.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"
#include "storage/blob/clip_codec.h"
#include "storage/blob/model_codec.h"
#include "storage/sql/tables/access_tables.h"
#include "storage/sql/tables/clip_table.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/edit_table.h"
#include "storage/sql/tables/operation_table.h"
#include "storage/sql/tables/segment_table.h"

namespace motiondb::storage {
namespace {

constexpr std::int64_t kStepBytes = 4 << 20;
constexpr int kVerifiedRows = 256;
constexpr std::size_t kBufferBytes = 64 << 10;
// Models up to this size are decoded, which needs about the same size of memory.
constexpr std::int64_t kDecodedModelBytes = 16 << 20;
// Estimated share of the file check in the whole verification, for progress().
constexpr double kFileShare = 0.2;

std::string MemberName(const std::string& database, const char* collection, const std::string& id) {
  return fmt::format("databases/{}/{}/{}", database, collection, id);
}

// Reads `bytes` bytes and passes them to `take` in pieces.
absl::Status ReadPieces(ByteSource& source, std::uint64_t bytes,
                        const std::function<void(std::span<const std::byte>)>& take) {
  std::vector<std::byte> buffer(std::min<std::uint64_t>(bytes, kBufferBytes));
  while (bytes > 0) {
    const auto piece = std::span(buffer).first(std::min<std::uint64_t>(bytes, buffer.size()));
    MOTIONDB_RETURN_IF_ERROR(source.Read(piece));
    take(piece);
    bytes -= piece.size();
  }
  return absl::OkStatus();
}

// DATA_LOSS if `parts` do not match the rows of the build.
absl::Status CheckIsOf(Connection& connection, std::int64_t built_key,
                       const core::ModelParts& parts) {
  Statement build = connection.Query(
      "SELECT clip_count, dimension_count FROM model WHERE model_key = ?", built_key);
  MOTIONDB_RETURN_IF_ERROR(build.Step().status());
  const auto clip_count = std::ssize(parts.clips);
  const auto dimension_count = parts.scale.divisor.size();
  if (build.Integer(0) != clip_count || build.Integer(1) != dimension_count) {
    return core::DataLoss("parts: expected {} clips of {} dimensions, got {} of {}",
                          build.Integer(0), build.Integer(1), clip_count, dimension_count);
  }
  Statement row = connection.Query(
      "SELECT id, frame_count FROM model_clip JOIN clip USING (clip_key) WHERE model_key = ? "
      "ORDER BY position",
      built_key);
  for (const core::ModelClip& clip : parts.clips) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found || row.Text(0) != clip.id || row.Integer(1) != clip.frame_count) {
      return core::DataLoss("parts: its clip '{}' of {} frames does not match the store", clip.id,
                            clip.frame_count);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<bool> SqlVerifier::Step(std::vector<Corruption>& found) {
  const std::int64_t bytes_before = totals_.byte_count;
  const Phase phase = phase_;
  bool found_corrupt_row = false;
  const absl::Status status = read_([&](Connection& connection) -> absl::Status {
    if (phase == Phase::kSchema) {
      Advance();
      return Note("", In("the file", CheckSchema(connection)));
    }
    if (phase == Phase::kFile) {
      const absl::Status checked = CheckFile(connection, file_bytes_);
      if (checked.ok()) Advance();
      return checked;
    }
    if (phase == Phase::kSearch) {
      Advance();
      return CheckSearchIndex(connection);
    }
    if (phase == Phase::kRecords) return CheckRecords(connection);
    if (phase == Phase::kRows) {
      const absl::Status checked = CheckRows(connection);
      found_corrupt_row = !found_.empty();
      return checked;
    }
    for (int row = 0; row < kVerifiedRows && totals_.byte_count - bytes_before < kStepBytes;
         ++row) {
      if (cancelled_ && cancelled_()) return absl::CancelledError("the verification was cancelled");
      absl::StatusOr<bool> more = false;
      if (phase == Phase::kClips) more = CheckClip(connection);
      if (phase == Phase::kSkeletons) more = CheckSkeleton(connection);
      if (phase == Phase::kModels) more = CheckModel(connection);
      if (phase == Phase::kEdits) more = CheckNextEdit(connection);
      if (!more.ok()) return more.status();
      if (!*more) {
        Advance();
        break;
      }
      // After corruption, SQLite may refuse to read on or to commit: begin a new transaction.
      found_corrupt_row = !found_.empty();
      if (found_corrupt_row) break;
    }
    return absl::OkStatus();
  });
  if (cancelled_ && cancelled_()) return absl::CancelledError("the verification was cancelled");
  if (!status.ok() && !found_corrupt_row) {
    // The rows cannot be listed: skip the rest of this phase.
    MOTIONDB_RETURN_IF_ERROR(Note("", status));
    if (phase_ == phase) Advance();
  }
  found.insert(found.end(), std::make_move_iterator(found_.begin()),
               std::make_move_iterator(found_.end()));
  found_.clear();
  return phase_ != Phase::kDone;
}

double SqlVerifier::progress() const {
  if (phase_ <= Phase::kSearch) return 0;
  if (phase_ == Phase::kDone) return 1;
  const double read = static_cast<double>(totals_.byte_count) / static_cast<double>(file_bytes_);
  return kFileShare + (1 - kFileShare) * std::min(1.0, read);
}

void SqlVerifier::Advance() {
  phase_ = static_cast<Phase>(static_cast<int>(phase_) + 1);
  last_key_ = 0;
}

absl::Status SqlVerifier::Note(const std::string& resource, const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
    case absl::StatusCode::kNotFound:  // deleted meanwhile
      return absl::OkStatus();
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kResourceExhausted:
      return status;
    default:
      ++totals_.corruption_count;
      found_.push_back({resource, std::string(status.message())});
      return absl::OkStatus();
  }
}

absl::StatusOr<bool> SqlVerifier::CheckClip(Connection& connection) {
  Statement row = connection.Query(
      "SELECT clip_key, name, id, clip.deleted, frame_count, root_path_crc, COALESCE((SELECT "
      "version "
      "FROM "
      "model WHERE model.database_key = clip.database_key AND current = 1), 0), database_key FROM "
      "clip "
      "JOIN database USING (database_key) WHERE database.deleted = 0 AND clip_key > ? AND "
      "(clip.deleted = 0 OR clip_key IN "
      "(SELECT clip_key FROM model_clip)) ORDER BY clip_key LIMIT 1",
      last_key_);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return false;
  last_key_ = row.Integer(0);
  const std::string database = row.Text(1);
  const std::string id = row.Text(2);
  const auto frames = row.Integer<std::int32_t>(4);
  const auto crc = row.Integer<std::uint32_t>(5);
  if (row.Integer(3) != 0) {
    // Deleted, but the current model uses its states.
    const std::string model = MemberName(database, "models", std::to_string(row.Integer(6)));
    MOTIONDB_RETURN_IF_ERROR(Note(model, In(fmt::format("deleted clip '{}'", id),
                                            CheckStates(connection, last_key_, frames, crc))));
    return true;
  }
  ++totals_.clip_count;
  const std::string name = MemberName(database, "clips", id);
  const BlobOwner owner = ClipOwner(last_key_);
  MOTIONDB_RETURN_IF_ERROR(
      Note(name, CheckAnnotations(connection, {row.Integer(7), last_key_, database, id})));
  MOTIONDB_RETURN_IF_ERROR(Note(name, CheckBytes(connection, owner, BlobKind::kMotionFile)));
  MOTIONDB_RETURN_IF_ERROR(Note(name, CheckBytes(connection, owner, BlobKind::kSkeletonFile)));
  MOTIONDB_RETURN_IF_ERROR(Note(name, CheckStates(connection, last_key_, frames, crc)));
  return true;
}

absl::Status SqlVerifier::CheckAnnotations(Connection& connection, const ClipRef& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(const ClipRecord record,
                            SelectClip(connection, clip.database, clip.clip));
  MOTIONDB_ASSIGN_OR_RETURN(const auto segments, SelectSegments(connection, clip));
  return CheckText(connection, clip.clip_key, TextOf(record, segments));
}

absl::StatusOr<bool> SqlVerifier::CheckNextEdit(Connection& connection) {
  Statement row = connection.Query(
      "SELECT edit_key, name, edit.revision FROM edit JOIN database USING (database_key) "
      "WHERE deleted = 0 AND edit_key > ? ORDER BY edit_key LIMIT 1",
      last_key_);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return false;
  last_key_ = row.Integer(0);
  MOTIONDB_RETURN_IF_ERROR(
      Note(MemberName(row.Text(1), "edits", row.Text(2)), CheckEdit(connection, last_key_)));
  return true;
}

absl::StatusOr<bool> SqlVerifier::CheckSkeleton(Connection& connection) {
  Statement row = connection.Query(
      "SELECT skeleton_key, name, id FROM skeleton JOIN database USING (database_key) "
      "WHERE deleted = 0 AND skeleton_key > ? ORDER BY skeleton_key LIMIT 1",
      last_key_);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return false;
  last_key_ = row.Integer(0);
  ++totals_.skeleton_count;
  const absl::Status read =
      ReadBlob(connection, {"skeleton", last_key_}, BlobKind::kSkeleton, [&](ByteSource& source) {
        totals_.byte_count += static_cast<std::int64_t>(source.remaining());
        return DecodeSkeleton(source).status();
      });
  MOTIONDB_RETURN_IF_ERROR(Note(MemberName(row.Text(1), "skeletons", row.Text(2)), read));
  return true;
}

absl::StatusOr<bool> SqlVerifier::CheckModel(Connection& connection) {
  Statement row = connection.Query(
      "SELECT model_key, name, version, COALESCE(base_key, model_key), clip_count, frame_count "
      "FROM model JOIN database USING (database_key) WHERE deleted = 0 AND current = 1 AND "
      "model_key > ? "
      "ORDER BY model_key LIMIT 1",
      last_key_);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return false;
  last_key_ = row.Integer(0);
  ++totals_.model_count;
  MOTIONDB_RETURN_IF_ERROR(
      Note(MemberName(row.Text(1), "models", row.Text(2)),
           CheckModelParts(connection, row.Integer(3), row.Integer(4), row.Integer(5))));
  return true;
}

absl::Status SqlVerifier::CheckRecords(Connection& connection) {
  Page page;
  while (true) {
    const auto databases = SelectDatabases(connection, page);
    MOTIONDB_RETURN_IF_ERROR(Note("", databases.status()));
    if (!databases.ok() || databases->empty()) break;
    totals_.database_count += static_cast<std::int32_t>(databases->size());
    page.after = databases->back().name;
  }
  std::string last;
  constexpr int kLimit = 1000;
  while (true) {
    const auto operations = SelectOperations(connection, "", last, kLimit);
    MOTIONDB_RETURN_IF_ERROR(Note("", operations.status()));
    if (!operations.ok() || operations->empty()) break;
    last = operations->back().id;
  }
  last.clear();
  while (true) {
    const auto tokens = SelectTokens(connection, last, kLimit);
    MOTIONDB_RETURN_IF_ERROR(Note("", tokens.status()));
    if (!tokens.ok() || tokens->empty()) break;
    last = tokens->back().id;
  }
  Advance();
  return absl::OkStatus();
}

absl::Status SqlVerifier::CheckRows(Connection& connection) {
  const std::string_view table = CheckedTables()[static_cast<std::size_t>(last_key_)];
  if (++last_key_ == std::ssize(CheckedTables())) Advance();
  const auto rows = FindChanged(connection, table);
  if (!rows.ok()) {
    return Note("", In(fmt::format("checksums of table {}", table), rows.status()));
  }
  for (const ChangedRow& row : *rows) {
    MOTIONDB_RETURN_IF_ERROR(
        Note(row.resource, core::DataLoss("{}: its checksum does not match", row.row)));
  }
  return absl::OkStatus();
}

absl::Status SqlVerifier::CheckBytes(Connection& connection, const BlobOwner& owner,
                                     BlobKind kind) {
  return ReadBlob(connection, owner, kind, [&](ByteSource& source) -> absl::Status {
    totals_.byte_count += static_cast<std::int64_t>(source.remaining());
    MOTIONDB_RETURN_IF_ERROR(ReadPieces(source, source.remaining(), [](auto) {}));
    return source.Finish();
  });
}

absl::Status SqlVerifier::CheckStates(Connection& connection, std::int64_t clip_key,
                                      std::int32_t frames, std::uint32_t root_path_crc) {
  const auto decode = [&](ByteSource& source) -> absl::Status {
    totals_.byte_count += static_cast<std::int64_t>(source.remaining());
    MOTIONDB_ASSIGN_OR_RETURN(const StatesHeader header, DecodeStatesHeader(source));
    if (header.frame_count != frames) {
      return core::DataLoss("states: expected {} frames, got {}", frames, header.frame_count);
    }
    const auto state_bytes = sizeof(float) * static_cast<std::uint64_t>(header.frame_count) *
                             static_cast<std::uint64_t>(header.dimension_count);
    MOTIONDB_RETURN_IF_ERROR(ReadPieces(source, state_bytes, [](auto) {}));
    std::uint32_t crc = 0;
    MOTIONDB_RETURN_IF_ERROR(
        ReadPieces(source, source.remaining(), [&](auto piece) { crc = Crc32(piece, crc); }));
    if (crc != root_path_crc) {
      return core::DataLoss("states: the root path does not match the clip");
    }
    return source.Finish();
  };
  return ReadBlob(connection, ClipOwner(clip_key), BlobKind::kStates, decode);
}

absl::Status SqlVerifier::CheckModelParts(Connection& connection, std::int64_t built_key,
                                          std::int64_t clip_count, std::int64_t frame_count) {
  Statement clips = connection.Query(
      "SELECT count(*), CAST(COALESCE(sum(frame_count), 0) AS bigint) FROM model_clip JOIN clip "
      "USING (clip_key) "
      "WHERE model_key = ?",
      built_key);
  MOTIONDB_RETURN_IF_ERROR(clips.Step().status());
  if (clips.Integer(0) != clip_count || clips.Integer(1) != frame_count) {
    return core::DataLoss("parts: expected {} clips with {} frames, got {} with {}", clip_count,
                          frame_count, clips.Integer(0), clips.Integer(1));
  }
  const BlobOwner owner{"model", built_key};
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t bytes,
                            BlobBytes(connection, owner, BlobKind::kModel));
  if (bytes > kDecodedModelBytes) return CheckBytes(connection, owner, BlobKind::kModel);
  totals_.byte_count += bytes;
  return ReadBlob(connection, owner, BlobKind::kModel, bytes,
                  [&](ByteSource& source) -> absl::Status {
                    MOTIONDB_ASSIGN_OR_RETURN(const core::ModelParts parts, DecodeModel(source));
                    return CheckIsOf(connection, built_key, parts);
                  });
}

}  // namespace motiondb::storage
