#include "storage/sqlite/sqlite_motion_store.h"

#include <string>

#include "core/motion/error.h"
#include "storage/sql/sql_motion_store_work.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/index_corruption.h"

namespace motiondb::storage {

absl::StatusOr<std::vector<TextMatch>> SqliteMotionStore::SearchClips(const std::string& database,
                                                                      const std::string& query) {
  const auto search = [&] {
    return Read(
        [&](Connection& connection) { return SelectTextMatches(connection, database, query); });
  };
  if (!index_is_corrupt_ || read_only_) {
    auto matches = search();
    if (!IsOfSearchIndex(matches.status())) return matches;
    if (read_only_) {
      return core::DataLoss(
          "the search index is corrupt: {}; without --read-only, a search rebuilds it",
          std::string(matches.status().message()));
    }
    index_is_corrupt_ = true;
  }
  // Any write transaction rebuilds the index.
  const auto nothing = [](Connection&) { return absl::OkStatus(); };
  MOTIONDB_RETURN_IF_ERROR(Write(Priority::kOrdinary, nothing, ReadScope::cancelled()));
  return search();
}

bool SqliteMotionStore::MayRepair(const absl::Status& error) {
  if (!IsOfSearchIndex(error)) return false;
  index_is_corrupt_ = true;
  return true;
}

}  // namespace motiondb::storage
