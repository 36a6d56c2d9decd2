#include "storage/sql/models/model_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "core/model/shared_rows.h"
#include "core/motion/error.h"
#include "storage/blob/checksums.h"
#include "storage/blob/clip_codec.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/clip_table.h"

namespace motiondb::storage {
namespace {

// A clip of a model, and its row.
struct WantedClip {
  const core::ModelClip& clip;
  std::uint32_t root_path_crc;
  std::int64_t key;  // 0: not found
};

// Sets the keys of those that are not found yet and have rows under a condition.
absl::Status FindWanted(Connection& connection, std::int64_t database_key,
                        std::string_view condition, std::vector<WantedClip>& wanted) {
  std::vector<WantedClip*> missing;
  for (WantedClip& clip : wanted) {
    if (clip.key == 0) missing.push_back(&clip);
  }
  constexpr std::size_t kAtOnce = 64;  // one wait for the network each
  // The newest row is the last: a clip whose states were replaced and that was then deleted has
  // several.
  std::string sql = fmt::format(
      "SELECT clip_key, id, frame_count, root_path_crc, leg_length_m FROM clip "
      "WHERE database_key = ? AND {} AND id IN (?",
      condition);
  for (std::size_t i = 1; i < kAtOnce; ++i) sql += ", ?";
  sql += ") ORDER BY clip_key";
  for (std::size_t first = 0; first < missing.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, missing.size() - first);
    const std::span group = std::span(missing).subspan(first, count);
    Statement row = connection.Query(sql, database_key);
    for (std::size_t i = 0; i < kAtOnce; ++i) row.Bind(group[std::min(i, count - 1)]->clip.id);
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) break;
      const std::string id = row.Text(1);
      for (WantedClip* const clip : group) {
        if (clip->clip.id == id && clip->clip.frame_count == row.Integer(2) &&
            clip->root_path_crc == row.Integer(3) && clip->clip.leg_length_m == row.Real(4)) {
          clip->key = row.Integer(0);
        }
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::int64_t>> FindModelClips(Connection& connection,
                                                         std::int64_t database_key,
                                                         const core::Model& model,
                                                         std::ptrdiff_t first, std::ptrdiff_t end,
                                                         DeletedClips deleted) {
  std::vector<WantedClip> wanted;
  for (const core::ModelClip& clip : std::span(model.clips()).subspan(first, end - first)) {
    const std::span root_path(model.root_path().row(clip.first_frame).data(),
                              3 * static_cast<std::size_t>(clip.frame_count));
    wanted.push_back({clip, Crc32(std::as_bytes(root_path)), 0});
  }
  // Two queries with constant `deleted`: with a parameter SQLite would not use the partial indices.
  MOTIONDB_RETURN_IF_ERROR(FindWanted(connection, database_key, "deleted = 0", wanted));
  if (deleted == DeletedClips::kToo) {
    MOTIONDB_RETURN_IF_ERROR(FindWanted(connection, database_key, "deleted = 1", wanted));
  }
  std::vector<std::int64_t> keys;
  keys.reserve(wanted.size());
  for (const WantedClip& clip : wanted) {
    if (clip.key == 0) {
      return core::NotFound("the clip '{}' that the model was built from is no longer stored",
                            clip.clip.id);
    }
    keys.push_back(clip.key);
  }
  return keys;
}

absl::Status InsertModelClips(Connection& connection, std::int64_t model_key, std::int64_t first,
                              const std::vector<std::int64_t>& clip_keys) {
  const std::string sql = fmt::format(
      "INSERT INTO model_clip (model_key, position, clip_key, row_crc) VALUES (?1, ?2, ?3, {})",
      connection.ChecksumOf("?1, ?2, ?3"));
  for (std::size_t i = 0; i < clip_keys.size(); ++i) {
    MOTIONDB_RETURN_IF_ERROR(
        connection.Query(sql, model_key, first + static_cast<std::int64_t>(i), clip_keys[i])
            .RunLater());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<ModelStates>> ModelStates::Find(Connection& connection,
                                                               std::int64_t current_key,
                                                               std::int64_t built_key) {
  std::unique_ptr<ModelStates> found(new ModelStates(current_key));
  MOTIONDB_RETURN_IF_ERROR(found->FindClips(connection, built_key));
  return found;
}

absl::Status ModelStates::FindClips(Connection& connection, std::int64_t built_key) {
  Statement build = connection.Query(
      "SELECT clip_count, dimension_count FROM model WHERE model_key = ?", built_key);
  MOTIONDB_RETURN_IF_ERROR(build.Step().status());
  const auto built_clips = build.Integer<std::size_t>(0);
  const std::int64_t dimensions = build.Integer(1);
  Statement row = connection.Query(
      "SELECT clip.clip_key, clip.id, clip.frame_count, count(clip_chunk.position), "
      "COALESCE(sum(length(chunk)), "
      "0) "
      "FROM model_clip JOIN clip USING (clip_key) LEFT JOIN clip_chunk "
      "ON clip_chunk.clip_key = clip.clip_key AND kind = ? WHERE model_key = ? "
      "GROUP BY model_clip.position, clip.clip_key ORDER BY model_clip.position",
      static_cast<int>(BlobKind::kStates), built_key);
  std::int64_t frames = 0;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) break;
    Clip clip{row.Integer(0),
              row.Text(1),
              static_cast<std::int32_t>(frames),
              row.Integer<std::int32_t>(2),
              PayloadBytes(row.Integer(3), row.Integer(4)),
              {},
              {}};
    if (clip.bytes / std::max<std::int64_t>(1, 4 * dimensions) < clip.frame_count) {
      return core::DataLoss("clip '{}': states: expected {} frames of {} dimensions, got {} bytes",
                            clip.id, clip.frame_count, dimensions, clip.bytes);
    }
    frames += clip.frame_count;
    if (clips_.size() == built_clips) {
      room_ += clip.frame_count;
    } else {
      clips_.push_back(std::move(clip));
    }
  }
  if (frames > std::numeric_limits<std::int32_t>::max()) {
    return core::DataLoss("parts: too many frames: {}", frames);
  }
  const std::int64_t built_frames = frames - room_;
  room_ = std::max<std::int64_t>(room_, core::RoomToGrow(built_frames));
  states_.resize(built_frames + room_, dimensions);
  root_path_.resize(built_frames, 3);
  return absl::OkStatus();
}

absl::Status ModelStates::ReadPending(Connection& connection) {
  Statement current =
      connection.Query("SELECT 1 FROM model WHERE model_key = ? AND current = 1", current_key_);
  MOTIONDB_ASSIGN_OR_RETURN(const bool same, current.Step());
  if (!same) return absl::OkStatus();
  for (std::size_t c = next_++; c < clips_.size(); c = next_++) {
    clips_[c].status = Read(connection, clips_[c]);
  }
  return absl::OkStatus();
}

absl::Status ModelStates::Read(Connection& connection, Clip& clip) {
  const auto dimensions = static_cast<std::int32_t>(states_.cols());
  const auto decode = [&](ByteSource& source) -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(StatesHeader header, DecodeStatesHeader(source));
    if (header.frame_count != clip.frame_count || header.dimension_count != dimensions) {
      return core::DataLoss("states: expected {} frames of {} dimensions, got {} of {}",
                            clip.frame_count, dimensions, header.frame_count,
                            header.dimension_count);
    }
    clip.glitches = std::move(header.glitches);
    const auto frames = static_cast<std::size_t>(clip.frame_count);
    return DecodeStatesFrames(source,
                              std::span(states_.row(clip.first_frame).data(), frames * dimensions),
                              std::span(root_path_.row(clip.first_frame).data(), 3 * frames));
  };
  return In(fmt::format("clip '{}'", clip.id),
            ReadBlob(connection, ClipOwner(clip.key), BlobKind::kStates, clip.bytes, decode));
}

absl::Status ModelStates::MoveInto(core::ModelParts& parts, const core::ParallelFor& parallel) {
  if (clips_.size() != parts.clips.size()) {
    return core::DataLoss("parts: expected {} clips, got {}", parts.clips.size(), clips_.size());
  }
  for (std::size_t c = 0; c < clips_.size(); ++c) {
    MOTIONDB_RETURN_IF_ERROR(clips_[c].status);
    if (clips_[c].frame_count != parts.clips[c].frame_count) {
      return core::DataLoss("clip '{}': states: expected {} frames, got {}", parts.clips[c].id,
                            parts.clips[c].frame_count, clips_[c].frame_count);
    }
    parts.clips[c].glitches = std::move(clips_[c].glitches);
  }
  if (states_.cols() != parts.scale.divisor.size()) {
    return core::DataLoss("parts: expected {} dimensions, got {}", parts.scale.divisor.size(),
                          states_.cols());
  }
  parts.states = core::ScaleRows(parts.scale, std::move(states_), room_, parallel);
  parts.root_path = std::move(root_path_);
  return absl::OkStatus();
}

}  // namespace motiondb::storage
