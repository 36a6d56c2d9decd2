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

}  // namespace motiondb::server
