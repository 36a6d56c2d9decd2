#include "storage/sql/models/model_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"

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

}  // namespace motiondb::storage
