#include "storage/edit_plan.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::storage {
namespace {

// A changed object: a clip (`segment` empty) or a segment.
struct ObjectName {
  std::string clip;
  std::string segment;

  bool operator==(const ObjectName&) const = default;
};

ObjectName NameOf(const EditedState& state) {
  if (const auto* const clip = std::get_if<ClipRecord>(&state)) return {clip->id, ""};
  const auto& segment = std::get<SegmentRecord>(state);
  return {segment.clip, segment.id};
}

const EditedState& AnyState(const EditedObject& object) {
  return object.after ? *object.after : *object.before;
}

absl::Status Changed(const ObjectName& object, std::string_view how) {
  return absl::AbortedError(object.segment.empty() ? fmt::format("clip '{}' {}", object.clip, how)
                                                   : fmt::format("clip '{}', segment '{}' {}",
                                                                 object.clip, object.segment, how));
}

absl::Status CheckSeen(const ObjectName& object, std::int64_t seen, std::int64_t stored) {
  if (seen == 0 || seen == stored) return absl::OkStatus();
  return Changed(object, "was changed since it was read: read it again and repeat the change");
}

std::vector<SegmentRecord>::iterator FindSegment(std::vector<SegmentRecord>& segments,
                                                 const std::string& id) {
  return std::ranges::find(segments, id, &SegmentRecord::id);
}

// Clips while they are changed in memory.
class EditPlan {
 public:
  EditPlan(std::string database, const LoadClip& load, const ChangeStamp& stamp)
      : database_(std::move(database)), load_(load), stamp_(stamp) {}

  absl::Status Apply(const Change& change) {
    return std::visit([this](const auto& one) { return Make(one); }, change);
  }

  // Restores the state before an edit of one object.
  absl::Status Restore(const EditedObject& object);
  // Checks the segments of all restored clips.
  absl::Status CheckRestored();

  // Returns the objects whose state differs, in order of their first change.
  std::vector<EditedObject> Finish();

 private:
  struct Clip {
    AnnotatedClip before;
    AnnotatedClip now;
  };

  absl::StatusOr<Clip*> Find(const std::string& id);
  absl::Status Make(const ClipChange& change);
  absl::Status Make(const SegmentCreation& change);
  absl::Status Make(const SegmentChange& change);
  absl::Status Make(const SegmentDeletion& change);
  absl::Status SetLabel(Clip& clip, const std::string& label);
  absl::StatusOr<SegmentRecord*> FindToChange(Clip& clip, const std::string& id, std::int64_t seen);
  void Touch(const ObjectName& object);
  // Updates the label of a clip after a change of its segments.
  void UpdateLabel(Clip& clip);
  EditedObject ObjectOf(Clip& clip, const ObjectName& name);

  const std::string database_;
  const LoadClip& load_;
  const ChangeStamp& stamp_;
  std::map<std::string, Clip> clips_;
  std::vector<ObjectName> touched_;  // in order, each once
};

absl::StatusOr<EditPlan::Clip*> EditPlan::Find(const std::string& id) {
  const auto found = clips_.find(id);
  if (found != clips_.end()) return &found->second;
  MOTIONDB_ASSIGN_OR_RETURN(AnnotatedClip loaded, load_(id));
  Clip clip{loaded, std::move(loaded)};
  return &clips_.emplace(id, std::move(clip)).first->second;
}

void EditPlan::Touch(const ObjectName& object) {
  if (std::ranges::find(touched_, object) == touched_.end()) touched_.push_back(object);
}

void EditPlan::UpdateLabel(Clip& clip) {
  std::string label = LabelOf(clip.now.segments);
  if (label == clip.now.record.label) return;
  clip.now.record.label = std::move(label);
  Touch({clip.now.record.id, ""});
}

absl::Status EditPlan::Make(const ClipChange& change) {
  MOTIONDB_ASSIGN_OR_RETURN(Clip* const clip, Find(change.clip));
  const ObjectName name{change.clip, ""};
  MOTIONDB_RETURN_IF_ERROR(CheckSeen(name, change.revision, clip->before.record.revision));
  Touch(name);
  ClipRecord& record = clip->now.record;
  if (change.subject) record.subject = *change.subject;
  if (change.title) record.title = *change.title;
  if (change.description) record.description = *change.description;
  if (change.tags) {
    record.tags = *change.tags;
    std::ranges::sort(record.tags);
    record.tags.erase(std::unique(record.tags.begin(), record.tags.end()), record.tags.end());
  }
  if (change.fields) record.fields = *change.fields;
  for (const auto& [field, value] : change.field) {
    if (value) {
      record.fields[field] = *value;
    } else {
      record.fields.erase(field);
    }
  }
  return change.label ? SetLabel(*clip, *change.label) : absl::OkStatus();
}

absl::Status EditPlan::SetLabel(Clip& clip, const std::string& label) {
  if (label == clip.now.record.label) return absl::OkStatus();
  auto& segments = clip.now.segments;
  const auto of_track = std::ranges::find(segments, kActionTrack, &SegmentRecord::track);
  std::string id;
  if (of_track == segments.end()) {
    SegmentRecord segment;
    segment.database = database_;
    segment.clip = clip.now.record.id;
    segment.label = label;
    segment.id = FindSegment(segments, kLabelSegment) == segments.end()
                     ? kLabelSegment
                     : ChooseSegmentId(segments, stamp_.revision);
    id = segment.id;
    segments.push_back(std::move(segment));
  } else if (!CoversClip(*of_track)) {
    return core::WithReason(
        "CLIP_HAS_SEGMENTS",
        core::FailedPrecondition("clip '{}' has segments on track '{}', so it has no label of its "
                                 "own; change their labels instead",
                                 clip.now.record.id, kActionTrack));
  } else {
    id = of_track->id;
    if (label.empty()) {
      segments.erase(of_track);
    } else {
      of_track->label = label;
      of_track->source = SegmentSource::kPerson;
      of_track->confidence = 1;
    }
  }
  Touch({clip.now.record.id, id});
  UpdateLabel(clip);
  return absl::OkStatus();
}

absl::Status EditPlan::Make(const SegmentCreation& change) {
  SegmentRecord segment = change.segment;
  MOTIONDB_ASSIGN_OR_RETURN(Clip* const clip, Find(segment.clip));
  auto& segments = clip->now.segments;
  segment.database = database_;
  if (segment.id.empty()) segment.id = ChooseSegmentId(segments, stamp_.revision);
  if (FindSegment(segments, segment.id) != segments.end()) {
    return core::WithReason("SEGMENT_EXISTS",
                            absl::AlreadyExistsError(fmt::format(
                                "clip '{}' already has a segment '{}'", segment.clip, segment.id)));
  }
  MOTIONDB_RETURN_IF_ERROR(FitToClip(clip->now.record, segment));
  segment.create_time_us = 0;
  const auto label = FindSegment(segments, kLabelSegment);
  if (label != segments.end() && label->track == segment.track && CoversClip(*label) &&
      !CoversClip(segment)) {
    Touch({segment.clip, label->id});
    segments.erase(label);
  }
  MOTIONDB_RETURN_IF_ERROR(CheckOverlap(segment, segments));
  Touch({segment.clip, segment.id});
  segments.push_back(std::move(segment));
  UpdateLabel(*clip);
  return absl::OkStatus();
}

absl::StatusOr<SegmentRecord*> EditPlan::FindToChange(Clip& clip, const std::string& id,
                                                      std::int64_t seen) {
  const ObjectName name{clip.now.record.id, id};
  const auto found = FindSegment(clip.now.segments, id);
  if (found == clip.now.segments.end()) return NoSegment(name.clip, id);
  const auto stored = FindSegment(clip.before.segments, id);
  MOTIONDB_RETURN_IF_ERROR(
      CheckSeen(name, seen, stored == clip.before.segments.end() ? -1 : stored->revision));
  Touch(name);
  return &*found;
}

absl::Status EditPlan::Make(const SegmentChange& change) {
  MOTIONDB_ASSIGN_OR_RETURN(Clip* const clip, Find(change.clip));
  MOTIONDB_ASSIGN_OR_RETURN(SegmentRecord* const stored,
                            FindToChange(*clip, change.id, change.revision));
  SegmentRecord segment = *stored;
  if (change.label) segment.label = *change.label;
  if (change.start_seconds) segment.start_seconds = *change.start_seconds;
  if (change.end_seconds) segment.end_seconds = *change.end_seconds;
  if (change.source) segment.source = *change.source;
  if (change.confidence) segment.confidence = *change.confidence;
  MOTIONDB_RETURN_IF_ERROR(FitToClip(clip->now.record, segment));
  MOTIONDB_RETURN_IF_ERROR(CheckOverlap(segment, clip->now.segments));
  *stored = std::move(segment);
  UpdateLabel(*clip);
  return absl::OkStatus();
}

absl::Status EditPlan::Make(const SegmentDeletion& change) {
  MOTIONDB_ASSIGN_OR_RETURN(Clip* const clip, Find(change.clip));
  MOTIONDB_RETURN_IF_ERROR(FindToChange(*clip, change.id, change.revision).status());
  clip->now.segments.erase(FindSegment(clip->now.segments, change.id));
  UpdateLabel(*clip);
  return absl::OkStatus();
}

absl::Status EditPlan::Restore(const EditedObject& object) {
  const ObjectName name = NameOf(AnyState(object));
  const auto found = Find(name.clip);
  if (absl::IsNotFound(found.status()))
    return Changed(name, "was deleted since: nothing is undone");
  if (!found.ok()) return found.status();
  Clip& clip = **found;
  const absl::Status changed = Changed(name, "was changed since: nothing is undone");
  Touch(name);
  if (name.segment.empty()) {
    if (!object.after || !object.before) return core::DataLoss("an edit that creates a clip");
    if (!SameState(std::get<ClipRecord>(*object.after), clip.before.record)) return changed;
    const auto& before = std::get<ClipRecord>(*object.before);
    ClipRecord& record = clip.now.record;
    record.subject = before.subject;
    record.title = before.title;
    record.description = before.description;
    record.tags = before.tags;
    record.fields = before.fields;
    return absl::OkStatus();
  }
  const auto stored = FindSegment(clip.before.segments, name.segment);
  const bool exists = stored != clip.before.segments.end();
  if (exists != object.after.has_value()) return changed;
  if (exists && !SameState(std::get<SegmentRecord>(*object.after), *stored)) return changed;
  auto& segments = clip.now.segments;
  std::erase_if(segments, [&](const SegmentRecord& other) { return other.id == name.segment; });
  if (object.before) segments.push_back(std::get<SegmentRecord>(*object.before));
  UpdateLabel(clip);
  return absl::OkStatus();
}

absl::Status EditPlan::CheckRestored() {
  for (auto& [id, clip] : clips_) {
    for (SegmentRecord& segment : clip.now.segments) {
      if (!FitToClip(clip.now.record, segment).ok()) {
        return Changed({id, segment.id}, "does not fit the clip, which is shorter than before");
      }
      MOTIONDB_RETURN_IF_ERROR(CheckOverlap(segment, clip.now.segments));
    }
  }
  return absl::OkStatus();
}

EditedObject EditPlan::ObjectOf(Clip& clip, const ObjectName& name) {
  EditedObject object;
  if (name.segment.empty()) {
    if (SameState(clip.before.record, clip.now.record)) return object;
    clip.now.record.revision = stamp_.revision;
    clip.now.record.edit_time_us = stamp_.time_us;
    return {clip.before.record, clip.now.record};
  }
  const auto before = FindSegment(clip.before.segments, name.segment);
  const auto now = FindSegment(clip.now.segments, name.segment);
  const bool existed = before != clip.before.segments.end();
  const bool exists = now != clip.now.segments.end();
  if (existed && exists && SameState(*before, *now)) return object;
  if (existed) object.before = *before;
  if (exists) {
    Stamp(*now, stamp_);
    object.after = *now;
  }
  return object;
}

std::vector<EditedObject> EditPlan::Finish() {
  std::vector<EditedObject> objects;
  for (const ObjectName& name : touched_) {
    EditedObject object = ObjectOf(clips_.at(name.clip), name);
    if (object.before || object.after) objects.push_back(std::move(object));
  }
  return objects;
}

// Adds the index of the change to an error.
absl::Status AtChange(std::size_t index, const absl::Status& status) {
  absl::Status at(status.code(),
                  fmt::format("changes[{}]: {}", index, std::string(status.message())));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { at.SetPayload(url, payload); });
  return at;
}

}  // namespace

absl::StatusOr<std::vector<EditedObject>> PlanEdit(const std::string& database,
                                                   std::span<const Change> changes,
                                                   const LoadClip& load, const ChangeStamp& stamp) {
  EditPlan plan(database, load, stamp);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const absl::Status applied = plan.Apply(changes[i]);
    if (!applied.ok()) return changes.size() > 1 ? AtChange(i, applied) : applied;
  }
  return plan.Finish();
}

absl::StatusOr<std::vector<EditedObject>> PlanUndo(const EditRecord& edit, const LoadClip& load,
                                                   const ChangeStamp& stamp) {
  EditPlan plan(edit.database, load, stamp);
  for (const EditedObject& object : edit.objects) {
    MOTIONDB_RETURN_IF_ERROR(plan.Restore(object));
  }
  MOTIONDB_RETURN_IF_ERROR(plan.CheckRestored());
  return plan.Finish();
}

const std::string& ClipOf(const EditedObject& object) {
  const EditedState& state = AnyState(object);
  const auto* const clip = std::get_if<ClipRecord>(&state);
  return clip != nullptr ? clip->id : std::get<SegmentRecord>(state).clip;
}

absl::Status NoSegment(const std::string& clip, const std::string& segment) {
  return core::WithReason("SEGMENT_NOT_FOUND",
                          core::NotFound("clip '{}' has no segment '{}'", clip, segment));
}

absl::Status NoEdit(const std::string& database, std::int64_t edit) {
  return core::WithReason("EDIT_NOT_FOUND",
                          core::NotFound("database '{}' has no edit {}; the last {} are kept",
                                         database, edit, kEditsKept));
}

absl::Status CheckRevision(std::int64_t after, std::int64_t begun, std::int64_t removed) {
  if (after == 0 || std::max(after, begun) >= removed) return absl::OkStatus();
  return core::WithReason("REVISION_TOO_OLD",
                          absl::OutOfRangeError(fmt::format(
                              "changes after revision {} are no longer complete: expected "
                              "a revision from {} on; read from revision 0 again",
                              after, removed)));
}

}  // namespace motiondb::storage
