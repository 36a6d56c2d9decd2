#include "server/engine/stored_clips.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {

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

absl::StatusOr<std::vector<core::BuildInput>> ReadInputs(
    storage::MotionStore& store, LiveDatabase& database, const std::vector<std::string>& clips,
    const std::function<bool(std::size_t)>& go_on) {
  std::vector<core::BuildInput> inputs;
  inputs.reserve(clips.size());
  for (const std::string& clip : clips) {
    if (go_on && !go_on(inputs.size())) return absl::CancelledError("stopped");
    const auto record = store.GetClip(database.name(), clip);
    auto states = record.ok() ? store.ReadClipStates(database.name(), clip) : record.status();
    if (absl::IsNotFound(states.status())) continue;
    if (absl::IsDataLoss(states.status())) {
      database.AddUnreadable(clip, std::string(states.status().message()));
      continue;
    }
    if (!states.ok()) return states.status();
    database.ForgetUnreadable(clip);  // the disk may have recovered
    inputs.push_back({clip, record->label, *std::move(states), record->subject});
  }
  return inputs;
}

}  // namespace motiondb::server
