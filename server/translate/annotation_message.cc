#include "server/translate/annotation_message.h"

#include <fmt/format.h>

#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/edit.pb.h"
#include "motiondb/v1/segment.pb.h"
#include "server/translate/message_fields.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

v1::SegmentSource ToProto(storage::SegmentSource source) {
  switch (source) {
    case storage::SegmentSource::kPerson:
      return v1::SEGMENT_SOURCE_PERSON;
    case storage::SegmentSource::kImport:
      return v1::SEGMENT_SOURCE_IMPORT;
    case storage::SegmentSource::kSuggestion:
      return v1::SEGMENT_SOURCE_SUGGESTION;
  }
  return v1::SEGMENT_SOURCE_UNSPECIFIED;
}

}  // namespace

void SetAnnotations(const storage::ClipRecord& record, v1::Clip& message) {
  message.set_title(record.title);
  message.set_description(record.description);
  for (const std::string& tag : record.tags) message.add_tags(tag);
  for (const auto& [name, value] : record.fields) {
    v1::FieldValue& to = (*message.mutable_fields())[name];
    if (const auto* text = std::get_if<std::string>(&value)) to.set_text(*text);
    if (const auto* number = std::get_if<double>(&value)) to.set_number(*number);
    if (const auto* flag = std::get_if<bool>(&value)) to.set_flag(*flag);
    if (const auto* time = std::get_if<storage::FieldTime>(&value)) {
      SetTimestamp(time->time_us, *to.mutable_time());
    }
  }
  if (record.revision > 0) message.set_etag(fmt::format("{}", record.revision));
  if (record.edit_time_us > 0) SetTimestamp(record.edit_time_us, *message.mutable_update_time());
}

void SetSegment(const storage::SegmentRecord& record, v1::Segment& message) {
  message.set_name(SegmentName(record.database, record.clip, record.id));
  message.set_track(record.track);
  message.set_label(record.label);
  message.set_start_seconds(record.start_seconds);
  if (record.end_seconds) message.set_end_seconds(*record.end_seconds);
  message.set_source(ToProto(record.source));
  message.set_confidence(record.confidence);
  if (record.revision > 0) message.set_etag(fmt::format("{}", record.revision));
  message.set_author(text::ValidUtf8(record.author));
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
  SetTimestamp(record.update_time_us, *message.mutable_update_time());
}

namespace {

// Sets those parts of a clip that edits change.
void SetEditedClip(const storage::ClipRecord& record, v1::Clip& message) {
  message.set_name(ClipName(record.database, record.id));
  message.set_label(record.label);
  message.set_subject(record.subject);
  SetAnnotations(record, message);
}

std::string NameOf(const storage::EditedState& state) {
  if (const auto* clip = std::get_if<storage::ClipRecord>(&state)) {
    return ClipName(clip->database, clip->id);
  }
  const auto& segment = std::get<storage::SegmentRecord>(state);
  return SegmentName(segment.database, segment.clip, segment.id);
}

}  // namespace

void SetEdit(const storage::EditRecord& record, v1::Edit& message) {
  if (record.id > 0) message.set_name(EditName(record.database, record.id));
  message.set_author(text::ValidUtf8(record.author));
  SetTimestamp(record.time_us, *message.mutable_create_time());
  for (const storage::EditedObject& object : record.objects) {
    v1::EditedObject& to = *message.add_objects();
    to.set_name(NameOf(object.after ? *object.after : *object.before));
    if (object.before) {
      if (const auto* clip = std::get_if<storage::ClipRecord>(&*object.before)) {
        SetEditedClip(*clip, *to.mutable_clip_before());
      } else {
        SetSegment(std::get<storage::SegmentRecord>(*object.before), *to.mutable_segment_before());
      }
    }
    if (object.after) {
      if (const auto* clip = std::get_if<storage::ClipRecord>(&*object.after)) {
        SetEditedClip(*clip, *to.mutable_clip_after());
      } else {
        SetSegment(std::get<storage::SegmentRecord>(*object.after), *to.mutable_segment_after());
      }
    }
  }
}

void SetChange(const std::string& database, const storage::ChangeRecord& record,
               v1::WatchDatabaseResponse& message) {
  message.set_revision(record.revision);
  if (const auto* clip = std::get_if<storage::ClipPut>(&record.change)) {
    SetClip(clip->clip, *message.mutable_clip());
  } else if (const auto* segment = std::get_if<storage::SegmentPut>(&record.change)) {
    SetSegment(segment->segment, *message.mutable_segment());
  } else if (const auto* model = std::get_if<storage::ModelPut>(&record.change)) {
    message.set_model_version(model->version);
  } else {
    const auto& deleted = std::get<storage::Deleted>(record.change);
    message.set_deleted(deleted.segment.empty()
                            ? ClipName(database, deleted.clip)
                            : SegmentName(database, deleted.clip, deleted.segment));
  }
}

}  // namespace motiondb::server
