// The annotation interface of SqlMotionStore.
#include <utility>

#include "core/motion/error.h"
#include "storage/edit_plan.h"
#include "storage/sql/sql_motion_store.h"
#include "storage/sql/sql_motion_store_work.h"
#include "storage/sql/tables/change_feed.h"
#include "storage/sql/tables/clip_row.h"
#include "storage/sql/tables/clip_text.h"
#include "storage/sql/tables/edit_table.h"
#include "storage/sql/tables/segment_table.h"

namespace motiondb::storage {

absl::StatusOr<EditRecord> SqlMotionStore::Edit(const std::string& database,
                                                std::span<const Change> changes,
                                                const std::string& author,
                                                const WriteOptions& terms) {
  const auto edit = [&](Connection& connection) {
    return MakeEdit(connection, database, changes, author, now_us_());
  };
  return WriteWith(terms, edit, Added(0));
}

absl::StatusOr<EditRecord> SqlMotionStore::UndoEdit(const std::string& database, std::int64_t edit,
                                                    const std::string& author,
                                                    const WriteOptions& terms) {
  const auto undo = [&](Connection& connection) {
    return UndoStoredEdit(connection, database, edit, author, now_us_());
  };
  return WriteWith(terms, undo, Added(0));
}

absl::StatusOr<std::vector<EditRecord>> SqlMotionStore::ListEdits(const std::string& database,
                                                                  const std::string& clip,
                                                                  std::int64_t before, int limit) {
  return Read([&](Connection& connection) {
    return SelectEdits(connection, database, clip, before, limit);
  });
}

absl::StatusOr<SegmentRecord> SqlMotionStore::GetSegment(const std::string& database,
                                                         const std::string& clip,
                                                         const std::string& segment) {
  MOTIONDB_ASSIGN_OR_RETURN(auto segments, ListSegments(database, clip));
  for (SegmentRecord& stored : segments) {
    if (stored.id == segment) return std::move(stored);
  }
  return NoSegment(clip, segment);
}

absl::StatusOr<std::vector<SegmentRecord>> SqlMotionStore::ListSegments(const std::string& database,
                                                                        const std::string& clip) {
  return Read([&](Connection& connection) -> absl::StatusOr<std::vector<SegmentRecord>> {
    MOTIONDB_ASSIGN_OR_RETURN(const ClipRef ref, FindClip(connection, database, clip));
    return SelectSegments(connection, ref);
  });
}

absl::StatusOr<std::int64_t> SqlMotionStore::Revision(const std::string& database) {
  return Read([&](Connection& connection) { return SelectRevision(connection, database); });
}

absl::StatusOr<std::vector<ChangeRecord>> SqlMotionStore::Changes(const std::string& database,
                                                                  std::int64_t after, int limit,
                                                                  std::int64_t begun) {
  return Read([&](Connection& connection) {
    return SelectChanges(connection, database, after, limit, begun);
  });
}

}  // namespace motiondb::storage
