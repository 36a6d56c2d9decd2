// What an edit changes. The same for every store: a store loads clips, plans, and stores the
// result.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/annotation_store.h"
#include "storage/clip_segments.h"

namespace motiondb::storage {

struct AnnotatedClip {
  ClipRecord record;
  std::vector<SegmentRecord> segments;
};

// Returns a clip with its segments. NOT_FOUND if it does not exist.
using LoadClip = std::function<absl::StatusOr<AnnotatedClip>(const std::string& clip)>;

// Returns what the changes change, with the revision of `stamp`; see AnnotationStore::Edit. Records
// of clips are complete. Empty: nothing. Each clip is loaded once, when it is first needed.
absl::StatusOr<std::vector<EditedObject>> PlanEdit(const std::string& database,
                                                   std::span<const Change> changes,
                                                   const LoadClip& load, const ChangeStamp& stamp);

// Returns what undoing an edit changes; see AnnotationStore::UndoEdit.
absl::StatusOr<std::vector<EditedObject>> PlanUndo(const EditRecord& edit, const LoadClip& load,
                                                   const ChangeStamp& stamp);

// Returns the id of the clip of an object.
const std::string& ClipOf(const EditedObject& object);

// Errors of missing objects.
absl::Status NoSegment(const std::string& clip, const std::string& segment);
absl::Status NoEdit(const std::string& database, std::int64_t edit);

// REVISION_TOO_OLD of AnnotationStore::Changes, if deletions since a revision were removed up to
// `removed`.
absl::Status CheckRevision(std::int64_t after, std::int64_t begun, std::int64_t removed);

// Limits of each database.
inline constexpr std::int64_t kEditsKept = 10'000;
inline constexpr std::int64_t kTombstonesKept = 100'000;

}  // namespace motiondb::storage
