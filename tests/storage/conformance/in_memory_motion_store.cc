#include "tests/storage/conformance/in_memory_motion_store.h"

#include <algorithm>

#include "core/motion/error.h"
#include "tests/storage/samples.h"

namespace motiondb::tests {
namespace {

using storage::ClipRecord;
using storage::DatabaseRecord;
using storage::NewClip;
using storage::OperationRecord;
using storage::Page;
using storage::SkeletonRecord;

// Returns a page of a map; `make` converts an entry to a record.
template <typename Record, typename Map, typename Make>
std::vector<Record> PageOf(const Map& map, const Page& page, const Make& make) {
  std::vector<Record> records;
  for (auto it = map.upper_bound(page.after);
       it != map.end() && static_cast<int>(records.size()) < page.limit; ++it) {
    records.push_back(make(*it));
  }
  return records;
}

template <typename Map>
std::string ChooseFreeId(const Map& map, const std::string& wanted) {
  std::string id = wanted;
  for (int number = 2; map.contains(id); ++number) id = fmt::format("{}-{}", wanted, number);
  return id;
}

}  // namespace

absl::StatusOr<InMemoryMotionStore::Database*> InMemoryMotionStore::Find(
    const std::string& database, std::int64_t id) {
  const auto found = databases_.find(database);
  if (found == databases_.end()) return core::NotFound("database '{}' does not exist", database);
  if (id != 0 && id != found->second.id) return absl::AbortedError("another one has its name");
  return &found->second;
}

absl::StatusOr<NewClip*> InMemoryMotionStore::FindClip(const std::string& database,
                                                       const std::string& clip) {
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  const auto found = in->clips.find(clip);
  if (found == in->clips.end()) {
    return core::NotFound("database '{}' has no clip '{}'", database, clip);
  }
  return &found->second;
}

absl::Status InMemoryMotionStore::Note(const storage::WriteOptions& terms) {
  return terms.audit != nullptr ? access_.AddAuditRecord(*terms.audit) : absl::OkStatus();
}

absl::Status InMemoryMotionStore::CreateDatabase(const DatabaseRecord& record,
                                                 const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  if (databases_.contains(record.name)) {
    return absl::AlreadyExistsError(fmt::format("database '{}' already exists", record.name));
  }
  Database& made = databases_[record.name];
  made.record = record;
  made.id = made.record.id = ++last_id_;
  return Note(terms);
}

absl::StatusOr<DatabaseRecord> InMemoryMotionStore::GetDatabase(const std::string& database) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const found, Find(database));
  return found->record;
}

absl::StatusOr<std::vector<storage::DatabaseState>> InMemoryMotionStore::ListDatabaseStates() {
  const std::lock_guard lock(mutex_);
  std::vector<storage::DatabaseState> states;
  for (const auto& [name, in] : databases_) {
    const auto of_markers =
        static_cast<std::int64_t>(std::hash<std::string>()(in.record.marker_set_text));
    states.push_back({name, in.id, in.revision, of_markers ^ in.revision});
  }
  return states;
}

absl::StatusOr<std::vector<DatabaseRecord>> InMemoryMotionStore::ListDatabases(const Page& page) {
  const std::lock_guard lock(mutex_);
  return PageOf<DatabaseRecord>(databases_, page,
                                [](const auto& entry) { return entry.second.record; });
}

absl::Status InMemoryMotionStore::ReplaceMarkerSet(const std::string& database,
                                                   const std::string& before,
                                                   const std::string& text,
                                                   const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const found, Find(database, terms.database_id));
  if (found->record.marker_set_text != before) return absl::AbortedError("marker set changed");
  found->record.marker_set_text = text;
  return Note(terms);
}

absl::Status InMemoryMotionStore::DeleteDatabase(const std::string& database,
                                                 const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_RETURN_IF_ERROR(Find(database, terms.database_id).status());
  databases_.erase(database);
  std::erase_if(operations_, [&](const auto& record) { return record.database == database; });
  return Note(terms);
}

absl::StatusOr<ClipRecord> InMemoryMotionStore::AddClip(const NewClip& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(clip.record.database, clip.database_id));
  return Add(*in, clip, {});
}

absl::StatusOr<ClipRecord> InMemoryMotionStore::Add(Database& in, const NewClip& clip,
                                                    const Segments& former) {
  if (clip.record.frame_count != clip.states.frame_count()) {
    return core::InvalidArgument("clip '{}': wrong frame_count", clip.record.id);
  }
  if (clip.states.root_path.rows() != clip.states.states.rows()) {
    return core::InvalidArgument("expected a root pose for each frame");
  }
  for (const auto& [id, stored] : in.clips) {
    if (stored.record.content_hash == clip.record.content_hash) {
      return absl::AlreadyExistsError(
          fmt::format("the database already has the same motion as clip '{}'", id));
    }
  }
  const std::string id = ChooseFreeId(in.clips, clip.record.id);
  if (clip.id_is_fixed && id != clip.record.id) {
    return absl::AlreadyExistsError(
        fmt::format("the database already has another clip '{}'", clip.record.id));
  }
  if (clip.marker_set_text) {
    std::string& text = in.record.marker_set_text;
    if (!text.empty() && text != *clip.marker_set_text) {
      return core::FailedPrecondition("the database already has another marker set");
    }
    text = *clip.marker_set_text;
  }
  NewClip stored = clip;
  stored.record.id = id;
  stored.record.skeleton_id.clear();
  stored.record.byte_count =
      static_cast<std::int64_t>(clip.file_bytes.size() + clip.skeleton_bytes.size() +
                                clip.states.states.size() * sizeof(float));
  if (clip.skeleton) {
    const auto alike = std::ranges::find_if(
        in.skeletons, [&](const auto& entry) { return Same(entry.second, *clip.skeleton); });
    stored.record.skeleton_id =
        alike == in.skeletons.end() ? ChooseFreeId(in.skeletons, "skeleton") : alike->first;
    in.skeletons.emplace(stored.record.skeleton_id, *clip.skeleton);
  }
  stored.record.revision = in.revision + 1;
  const storage::ChangeStamp stamp{clip.author, stored.record.create_time_us,
                                   stored.record.revision};
  MOTIONDB_ASSIGN_OR_RETURN(Segments segments,
                            storage::SegmentsOf(clip, stored.record, former, stamp));
  stored.segments.clear();
  stored.record.label = storage::LabelOf(segments);
  if (clip.audit) {
    MOTIONDB_RETURN_IF_ERROR(access_.AddAuditRecord(clip.audit(stored.record)));
  }
  in.revision = stored.record.revision;
  for (const auto& segment : former) {
    const bool stays =
        std::ranges::find(segments, segment.id, &storage::SegmentRecord::id) != segments.end();
    if (!stays && segment.clip == id) Bury(in, {id, segment.id}, in.revision);
  }
  for (const auto& segment : segments) Unbury(in, {id, segment.id});
  in.clips.emplace(id, std::move(stored));
  SetSegments(in, id, std::move(segments));
  return in.clips.at(id).record;
}

absl::StatusOr<ClipRecord> InMemoryMotionStore::FindSameClip(const NewClip& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(clip.record.database));
  for (const auto& [id, stored] : in->clips) {
    if (stored.record.content_hash == clip.record.content_hash) return stored.record;
  }
  const auto named = in->clips.find(clip.record.id);
  if (clip.id_is_fixed && named != in->clips.end()) return named->second.record;
  return absl::NotFoundError("no such clip");
}

absl::StatusOr<ClipRecord> InMemoryMotionStore::ReplaceClip(const ClipRecord& before,
                                                            const NewClip& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(before.database, clip.database_id));
  const auto stored = in->clips.find(before.id);
  if (stored == in->clips.end() || stored->second.record.content_hash != before.content_hash ||
      stored->second.record.create_time_us != before.create_time_us) {
    return absl::AbortedError("the clip has changed");
  }
  const Database unchanged = *in;
  NewClip next = clip;
  storage::KeepAnnotations(stored->second.record, next.record);
  const Segments segments = in->segments.at(before.id);
  Remove(*in, before.id);
  auto added = Add(*in, next, segments);
  if (!added.ok()) {
    *in = unchanged;
    return added;
  }
  if (in->model) in->replaced.insert(before.id);
  if (added->id != before.id) Bury(*in, {before.id, ""}, in->revision);
  return added;
}

absl::StatusOr<ClipRecord> InMemoryMotionStore::GetClip(const std::string& database,
                                                        const std::string& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const NewClip* const found, FindClip(database, clip));
  return found->record;
}

absl::StatusOr<std::vector<ClipRecord>> InMemoryMotionStore::ListClips(const std::string& database,
                                                                       const Page& page) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  return PageOf<ClipRecord>(in->clips, page, [](const auto& entry) { return entry.second.record; });
}

absl::StatusOr<ClipRecord> InMemoryMotionStore::DeleteClip(const std::string& database,
                                                           const std::string& clip,
                                                           const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const NewClip* const found, FindClip(database, clip));
  ClipRecord record = found->record;
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database, terms.database_id));
  Remove(*in, clip);
  Bury(*in, {clip, ""}, ++in->revision);
  MOTIONDB_RETURN_IF_ERROR(Note(terms));
  return record;
}

void InMemoryMotionStore::Remove(Database& in, const std::string& clip) {
  const auto found = in.clips.find(clip);
  const std::string skeleton = found->second.record.skeleton_id;
  in.deleted.push_back(std::move(found->second));
  in.clips.erase(found);
  in.segments.erase(clip);
  const bool used = std::ranges::any_of(
      in.clips, [&](const auto& entry) { return entry.second.record.skeleton_id == skeleton; });
  if (!used) in.skeletons.erase(skeleton);
}

absl::StatusOr<storage::ClipSource> InMemoryMotionStore::ReadClipSource(const std::string& database,
                                                                        const std::string& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const NewClip* const found, FindClip(database, clip));
  return storage::ClipSource{found->file_bytes, found->skeleton_bytes};
}

absl::StatusOr<core::StateSequence> InMemoryMotionStore::ReadClipStates(const std::string& database,
                                                                        const std::string& clip) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const NewClip* const found, FindClip(database, clip));
  return found->states;
}

absl::StatusOr<std::vector<ClipRecord>> InMemoryMotionStore::PutDerived(
    const std::string& database, std::span<const storage::DerivedClip> clips, std::int64_t fence) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(Database* const in, Find(database));
  MOTIONDB_RETURN_IF_ERROR(CheckTerms(*in, {std::nullopt, fence}));
  for (const storage::DerivedClip& clip : clips) {
    if (clip.states && clip.record.frame_count != clip.states->frame_count()) {
      return core::InvalidArgument("clip '{}': wrong frame_count", clip.record.id);
    }
  }
  std::vector<ClipRecord> stored;
  for (const storage::DerivedClip& clip : clips) {
    const auto found = in->clips.find(clip.record.id);
    if (found == in->clips.end() || found->second.record.content_hash != clip.record.content_hash ||
        found->second.record.create_time_us != clip.record.create_time_us) {
      continue;
    }
    if (stored.empty()) ++in->revision;
    NewClip& to = found->second;
    ClipRecord record = clip.record;
    storage::CopyAnnotations(to.record, record);
    record.revision = in->revision;
    if (clip.states) {
      in->deleted.push_back(to);
      in->replaced.insert(record.id);
      to.states = *clip.states;
    }
    to.record = record;
    if (clip.states) {
      Segments segments = in->segments.at(record.id);
      storage::AdaptToClip(record, {"", record.tried_time_us, in->revision}, segments);
      for (const auto& former : in->segments.at(record.id)) {
        const auto found_again =
            std::ranges::find(segments, former.id, &storage::SegmentRecord::id);
        if (found_again == segments.end()) Bury(*in, {record.id, former.id}, in->revision);
      }
      SetSegments(*in, record.id, std::move(segments));
    }
    stored.push_back(to.record);
  }
  return stored;
}

absl::StatusOr<core::Skeleton> InMemoryMotionStore::GetSkeleton(const std::string& database,
                                                                const std::string& skeleton) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  const auto found = in->skeletons.find(skeleton);
  if (found == in->skeletons.end()) {
    return core::NotFound("database '{}' has no skeleton '{}'", database, skeleton);
  }
  return found->second;
}

absl::StatusOr<std::vector<SkeletonRecord>> InMemoryMotionStore::ListSkeletons(
    const std::string& database, const Page& page) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(database));
  return PageOf<SkeletonRecord>(in->skeletons, page, [](const auto& entry) {
    return SkeletonRecord{entry.first, entry.second};
  });
}

absl::Status InMemoryMotionStore::PutOperation(const OperationRecord& record,
                                               const core::Cancelled&) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const Database* const in, Find(record.database, record.database_id));
  const auto stored = std::ranges::find(operations_, record.id, &OperationRecord::id);
  if (stored == operations_.end()) {
    operations_.push_back(record);
    operations_.back().database_id = in->id;
  } else if (stored->done()) {
    return absl::AbortedError("the operation has already ended");
  } else {
    *stored = record;
    stored->database_id = in->id;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<OperationRecord>> InMemoryMotionStore::ListUnfinishedOperations() {
  const std::lock_guard lock(mutex_);
  std::vector<OperationRecord> unfinished;
  for (const OperationRecord& record : operations_) {
    if (!record.done()) unfinished.push_back(record);
  }
  return unfinished;
}

absl::StatusOr<OperationRecord> InMemoryMotionStore::GetOperation(const std::string& operation) {
  const std::lock_guard lock(mutex_);
  const auto stored = std::ranges::find(operations_, operation, &OperationRecord::id);
  if (stored == operations_.end()) {
    return core::NotFound("operation '{}' does not exist", operation);
  }
  return *stored;
}

absl::StatusOr<std::vector<OperationRecord>> InMemoryMotionStore::ListOperations(
    const std::string& database, const std::string& before, int limit) {
  const std::lock_guard lock(mutex_);
  if (!database.empty()) MOTIONDB_RETURN_IF_ERROR(Find(database).status());
  auto end = operations_.rbegin();
  if (!before.empty()) {
    end = std::find_if(end, operations_.rend(), [&](const auto& r) { return r.id == before; });
    if (end == operations_.rend()) {
      return core::NotFound("operation '{}' does not exist", before);
    }
    ++end;
  }
  std::vector<OperationRecord> records;
  for (auto it = end; it != operations_.rend(); ++it) {
    if (static_cast<int>(records.size()) == limit) break;
    if (database.empty() || it->database == database) records.push_back(*it);
  }
  return records;
}

}  // namespace motiondb::tests
