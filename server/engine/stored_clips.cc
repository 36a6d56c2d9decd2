#include "server/engine/stored_clips.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/newer_format.h"
#include "storage/clip_segments.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kClipsAtOnce = 16;

absl::StatusOr<core::BuildInput> ReadInput(storage::MotionStore& store, const std::string& database,
                                           const Catalog& catalog, const std::string& clip) {
  const CatalogClip* const stored = catalog.Find(clip);
  if (stored == nullptr) return core::NotFound("clip '{}' was deleted", clip);
  MOTIONDB_ASSIGN_OR_RETURN(auto states, store.ReadClipStates(database, clip));
  auto labels =
      storage::LabelTracksOf(stored->segments, states.frame_rate_hz, states.frame_count());
  return core::BuildInput{clip, std::move(labels), std::move(states), stored->subject};
}

}  // namespace

absl::StatusOr<std::vector<storage::ClipRecord>> AllClips(storage::MotionStore& store,
                                                          const std::string& database) {
  storage::Page page{.after = "", .limit = 1000};
  std::vector<storage::ClipRecord> clips;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(auto next, store.ListClips(database, page));
    const bool last = static_cast<int>(next.size()) < page.limit;
    std::ranges::move(next, std::back_inserter(clips));
    if (last) return clips;
    page.after = clips.back().id;
  }
}

absl::Status CheckNoneIsNewer(const std::vector<storage::ClipRecord>& clips) {
  const auto newer = std::ranges::find_if(clips, [](const storage::ClipRecord& clip) {
    return clip.representation_version > core::kRepresentationVersion;
  });
  if (newer == clips.end()) return absl::OkStatus();
  return storage::NewerFormat(fmt::format("clip '{}'", newer->id));
}

absl::Status UnknownMarkers(storage::MotionStore& store, const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, store.GetDatabase(database));
  if (record.marker_set_text.empty()) {
    return absl::InternalError(fmt::format("database '{}' has clips but no markers", database));
  }
  return absl::UnavailableError(
      fmt::format("the markers of database '{}' are not known yet", database));
}

absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const core::ParallelFor& parallel, const std::function<bool(std::size_t)>& go_on) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, database.Catalog(store.annotations()));
  std::vector<core::BuildInput> inputs;
  inputs.reserve(clips.size());
  for (std::size_t first = 0; first < clips.size(); first += kClipsAtOnce) {
    if (go_on && !go_on(first)) return absl::CancelledError("stopped");
    const std::size_t count = std::min(kClipsAtOnce, clips.size() - first);
    std::vector<absl::StatusOr<core::BuildInput>> read(count);
    parallel(static_cast<int>(count), [&](int i) {
      read[i] = ReadInput(store, database.name(), *catalog, clips[first + i]);
    });
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& clip = clips[first + i];
      if (absl::IsNotFound(read[i].status())) continue;
      if (absl::IsDataLoss(read[i].status())) {
        database.AddUnreadable(clip, std::string(read[i].status().message()));
        continue;
      }
      if (!read[i].ok()) return read[i].status();
      database.ForgetUnreadable(clip);  // the disk may have recovered
      inputs.push_back(*std::move(read[i]));
    }
  }
  return inputs;
}

}  // namespace motiondb::server
