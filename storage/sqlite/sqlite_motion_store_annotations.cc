// The annotation interface of SqliteMotionStore.
#include <utility>

#include "core/motion/error.h"
#include "storage/edit_plan.h"
#include "storage/sqlite/change_feed.h"
#include "storage/sqlite/clip_row.h"
#include "storage/sqlite/clip_search.h"
#include "storage/sqlite/edit_table.h"
#include "storage/sqlite/segment_table.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "storage/sqlite/sqlite_motion_store_work.h"

namespace motiondb::storage {

absl::StatusOr<EditRecord> SqliteMotionStore::Edit(const std::string& database,
                                                   std::span<const Change> changes,
                                                   const std::string& author,
                                                   const WriteOptions& terms) {
  const auto edit = [&](Connection& connection) {
    return MakeEdit(connection, database, changes, author, now_us_());
  };
  return WithSearchIndex([&] { return WriteWith(terms, edit, Added(0)); });
}

absl::StatusOr<EditRecord> SqliteMotionStore::UndoEdit(const std::string& database,
                                                       std::int64_t edit, const std::string& author,
                                                       const WriteOptions& terms) {
  const auto undo = [&](Connection& connection) {
    return UndoStoredEdit(connection, database, edit, author, now_us_());
  };
  return WithSearchIndex([&] { return WriteWith(terms, undo, Added(0)); });
}

absl::StatusOr<std::vector<EditRecord>> SqliteMotionStore::ListEdits(const std::string& database,
                                                                     const std::string& clip,
                                                                     std::int64_t before,
                                                                     int limit) {
  return Read([&](Connection& connection) {
    return SelectEdits(connection, database, clip, before, limit);
  });
}

absl::StatusOr<SegmentRecord> SqliteMotionStore::GetSegment(const std::string& database,
                                                            const std::string& clip,
                                                            const std::string& segment) {
  MOTIONDB_ASSIGN_OR_RETURN(auto segments, ListSegments(database, clip));
  for (SegmentRecord& stored : segments) {
    if (stored.id == segment) return std::move(stored);
  }
  return NoSegment(clip, segment);
}

absl::StatusOr<std::vector<SegmentRecord>> SqliteMotionStore::ListSegments(
    const std::string& database, const std::string& clip) {
  return Read([&](Connection& connection) -> absl::StatusOr<std::vector<SegmentRecord>> {
    MOTIONDB_ASSIGN_OR_RETURN(const ClipRef ref, FindClip(connection, database, clip));
    return SelectSegments(connection, ref);
  });
}

absl::StatusOr<std::int64_t> SqliteMotionStore::Revision(const std::string& database) {
  return Read([&](Connection& connection) { return SelectRevision(connection, database); });
}

absl::StatusOr<std::vector<ChangeRecord>> SqliteMotionStore::Changes(const std::string& database,
                                                                     std::int64_t after, int limit,
                                                                     std::int64_t begun) {
  return Read([&](Connection& connection) {
    return SelectChanges(connection, database, after, limit, begun);
  });
}

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

}  // namespace motiondb::storage
