#include "server/engine/clip_list.h"

#include <algorithm>
#include <iterator>

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

bool IsBuiltFrom(const Snapshot& snapshot, const std::vector<storage::ClipRecord>& clips) {
  const auto build_us = static_cast<std::int64_t>(snapshot.record.build_seconds * 1e6);
  const std::int64_t build_began_us = snapshot.record.create_time_us - build_us;
  return std::ranges::equal(
      snapshot.model.clips(), clips,
      [&](const core::ModelClip& in_model, const storage::ClipRecord& stored) {
        return in_model.id == stored.id && in_model.label == stored.label &&
               in_model.frame_count == stored.frame_count &&
               stored.create_time_us <= build_began_us;
      });
}

}  // namespace motiondb::server
