// The annotations of InMemoryMotionStore.
#include <algorithm>
#include <cstddef>
#include <limits>
#include <mutex>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/motion/error.h"
#include "storage/text_query.h"
#include "tests/storage/conformance/in_memory_motion_store.h"

namespace motiondb::tests {

using storage::EditRecord;
using storage::SegmentRecord;

void InMemoryMotionStore::SetSegments(Database& in, const std::string& clip, Segments segments) {
  storage::SortSegments(segments);
  in.clips.at(clip).record.label = storage::LabelOf(segments);
  in.segments[clip] = std::move(segments);
}

void InMemoryMotionStore::Unbury(Database& in, const storage::Deleted& deleted) {
  std::erase_if(in.tombstones, [&](const Tombstone& tombstone) {
    return tombstone.deleted.clip == deleted.clip && tombstone.deleted.segment == deleted.segment;
  });
}

void InMemoryMotionStore::Bury(Database& in, const storage::Deleted& deleted,
                               std::int64_t revision) {
  std::erase_if(in.tombstones, [&](const Tombstone& tombstone) {
    return tombstone.deleted.clip == deleted.clip &&
           (deleted.segment.empty() || tombstone.deleted.segment == deleted.segment);
  });
  in.tombstones.push_back({revision, deleted});
  if (std::ssize(in.tombstones) <= storage::kTombstonesKept) return;
  in.removed_revision = in.tombstones.front().revision;
  in.tombstones.erase(in.tombstones.begin());
}

absl::StatusOr<EditRecord> InMemoryMotionStore::Make(Database& in, const Plan& plan,
                                                     const std::string& author,
                                                     const storage::WriteOptions& terms) {
  const std::string& database = in.record.name;
  const storage::LoadClip load =
      [&](const std::string& id) -> absl::StatusOr<storage::AnnotatedClip> {
    MOTIONDB_ASSIGN_OR_RETURN(const storage::NewClip* const clip, FindClip(database, id));
    return storage::AnnotatedClip{clip->record, in.segments.at(id)};
  };
  EditRecord edit;
  edit.database = database;
  edit.author = author;
  edit.time_us = put_time_us_;
  MOTIONDB_ASSIGN_OR_RETURN(edit.objects, plan(load, {author, put_time_us_, in.revision + 1}));
  if (!edit.objects.empty()) {
    edit.id = ++in.revision;
    for (const storage::EditedObject& object : edit.objects) {
      const std::string& clip = storage::ClipOf(object);
      if (object.after && std::holds_alternative<storage::ClipRecord>(*object.after)) {
        in.clips.at(clip).record = std::get<storage::ClipRecord>(*object.after);
        continue;
      }
      const auto id = std::get<SegmentRecord>(object.after ? *object.after : *object.before).id;
      Segments segments = in.segments.at(clip);
      std::erase_if(segments, [&](const SegmentRecord& segment) { return segment.id == id; });
      Unbury(in, {clip, id});
      if (object.after) {
        segments.push_back(std::get<SegmentRecord>(*object.after));
      } else {
        Bury(in, {clip, id}, edit.id);
      }
      SetSegments(in, clip, std::move(segments));
    }
    in.edits.push_back(edit);
    if (std::ssize(in.edits) > storage::kEditsKept) in.edits.erase(in.edits.begin());
  }
  if (edit.id != 0) MOTIONDB_RETURN_IF_ERROR(Note(terms));
  return edit;
}

absl::StatusOr<EditRecord> InMemoryMotionStore::Edit(const std::string& database,
                                                     std::span<const storage::Change> changes,
                                                     const std::string& author,
                                                     const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database, terms.database_id));
  const auto plan = [&](const storage::LoadClip& load, const storage::ChangeStamp& stamp) {
    return storage::PlanEdit(database, changes, load, stamp);
  };
  return Make(*in, plan, author, terms);
}

absl::StatusOr<EditRecord> InMemoryMotionStore::UndoEdit(const std::string& database,
                                                         std::int64_t edit,
                                                         const std::string& author,
                                                         const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database, terms.database_id));
  const auto found = std::ranges::find(in->edits, edit, &EditRecord::id);
  if (found == in->edits.end()) return storage::NoEdit(database, edit);
  const EditRecord undone = *found;
  const auto plan = [&](const storage::LoadClip& load, const storage::ChangeStamp& stamp) {
    return storage::PlanUndo(undone, load, stamp);
  };
  return Make(*in, plan, author, terms);
}

absl::StatusOr<std::vector<EditRecord>> InMemoryMotionStore::ListEdits(const std::string& database,
                                                                       const std::string& clip,
                                                                       std::int64_t before,
                                                                       int limit) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  std::vector<EditRecord> edits;
  for (auto edit = in->edits.rbegin(); edit != in->edits.rend(); ++edit) {
    if (static_cast<int>(edits.size()) == limit) break;
    const bool is_of_clip = clip.empty() || std::ranges::any_of(edit->objects, [&](const auto& o) {
                              return storage::ClipOf(o) == clip;
                            });
    if (is_of_clip && (before == 0 || edit->id < before)) edits.push_back(*edit);
  }
  return edits;
}

absl::StatusOr<SegmentRecord> InMemoryMotionStore::GetSegment(const std::string& database,
                                                              const std::string& clip,
                                                              const std::string& segment) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto segments, ListSegments(database, clip));
  const auto found = std::ranges::find(segments, segment, &SegmentRecord::id);
  if (found == segments.end()) return storage::NoSegment(clip, segment);
  return *found;
}

absl::StatusOr<std::vector<SegmentRecord>> InMemoryMotionStore::ListSegments(
    const std::string& database, const std::string& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_RETURN_IF_ERROR(FindClip(database, clip).status());
  return (*Find(database))->segments.at(clip);
}

absl::StatusOr<std::int64_t> InMemoryMotionStore::Revision(const std::string& database) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  return in->revision;
}

absl::StatusOr<std::vector<storage::ChangeRecord>> InMemoryMotionStore::Changes(
    const std::string& database, std::int64_t after, int limit, std::int64_t begun) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  MOTIONDB_RETURN_IF_ERROR(storage::CheckRevision(after, begun, in->removed_revision));
  std::vector<storage::ChangeRecord> changes;
  for (const auto& [revision, deleted] : in->tombstones) changes.push_back({revision, deleted});
  for (const auto& [id, clip] : in->clips) {
    changes.push_back({clip.record.revision, storage::ClipPut{clip.record}});
  }
  for (const auto& [id, segments] : in->segments) {
    for (const SegmentRecord& segment : segments) {
      changes.push_back({segment.revision, storage::SegmentPut{segment}});
    }
  }
  if (in->model_revision > 0) {
    const int version = in->model ? in->models.back().version : 0;
    changes.push_back({in->model_revision, storage::ModelPut{version}});
  }
  std::erase_if(changes, [&](const auto& change) { return change.revision <= after; });
  std::ranges::stable_sort(changes, {}, &storage::ChangeRecord::revision);
  if (std::ssize(changes) > limit) {
    const std::int64_t last = changes[static_cast<std::size_t>(limit) - 1].revision;
    std::erase_if(changes, [&](const auto& change) { return change.revision > last; });
  }
  return changes;
}

absl::StatusOr<std::vector<storage::TextMatch>> InMemoryMotionStore::SearchClips(
    const std::string& database, const std::string& query) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto terms, storage::ParseTextQuery(query));
  std::vector<storage::TextMatch> matches;
  for (const auto& [id, clip] : in->clips) {
    const auto text = storage::TextOf(clip.record, in->segments.at(id));
    if (storage::Matches(text, terms)) matches.push_back({id, 1});
  }
  return matches;
}

}  // namespace motiondb::tests
