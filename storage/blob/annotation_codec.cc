#include "storage/blob/annotation_codec.h"

#include <cstdint>
#include <utility>

#include "core/motion/error.h"
#include "storage/blob/byte_stream.h"

namespace motiondb::storage {
namespace {

constexpr std::uint8_t kVersion = 1;
// Minimum sizes of an encoded text, field and object.
constexpr std::size_t kTextBytes = sizeof(std::uint32_t);
constexpr std::size_t kFieldBytes = kTextBytes + 2;
constexpr std::size_t kObjectBytes = 2 + kTextBytes;

// Stored: never change a number.
enum class ValueKind : std::uint8_t { kText = 0, kNumber = 1, kFlag = 2, kTime = 3 };
enum class ObjectKind : std::uint8_t { kClip = 0, kSegment = 1 };
constexpr std::uint8_t kHasBefore = 1;
constexpr std::uint8_t kHasAfter = 2;

void PutFlag(FieldWriter& writer, bool flag) { writer.Put<std::uint8_t>(flag ? 1 : 0); }

bool GetFlag(FieldReader& reader) {
  const auto flag = reader.Get<std::uint8_t>();
  if (flag > 1) reader.Fail(core::DataLoss("expected 0 or 1, got {}", flag));
  return flag == 1;
}

void PutValue(FieldWriter& writer, const FieldValue& value) {
  writer.Put(static_cast<std::uint8_t>(value.index()));
  if (const auto* const text = std::get_if<std::string>(&value)) writer.PutText(*text);
  if (const auto* const number = std::get_if<double>(&value)) writer.Put(*number);
  if (const auto* const flag = std::get_if<bool>(&value)) PutFlag(writer, *flag);
  if (const auto* const time = std::get_if<FieldTime>(&value)) writer.Put(time->time_us);
}

FieldValue GetValue(FieldReader& reader) {
  const auto kind = reader.Get<std::uint8_t>();
  switch (static_cast<ValueKind>(kind)) {
    case ValueKind::kText:
      return reader.GetText();
    case ValueKind::kNumber:
      return reader.Get<double>();
    case ValueKind::kFlag:
      return GetFlag(reader);
    case ValueKind::kTime:
      return FieldTime{reader.Get<std::int64_t>()};
  }
  reader.Fail(core::DataLoss("unknown kind {} of a field", kind));
  return {};
}

void PutTagsAndFields(FieldWriter& writer, const ClipRecord& clip) {
  writer.PutCount(clip.tags.size());
  for (const std::string& tag : clip.tags) writer.PutText(tag);
  writer.PutCount(clip.fields.size());
  for (const auto& [name, value] : clip.fields) {
    writer.PutText(name);
    PutValue(writer, value);
  }
}

void GetTagsAndFields(FieldReader& reader, ClipRecord& clip) {
  clip.tags.resize(reader.GetCount(kTextBytes));
  for (std::string& tag : clip.tags) tag = reader.GetText();
  const std::size_t fields = reader.GetCount(kFieldBytes);
  for (std::size_t i = 0; i < fields && reader.ok(); ++i) {
    std::string name = reader.GetText();
    clip.fields.insert_or_assign(std::move(name), GetValue(reader));
  }
}

void PutState(FieldWriter& writer, const ClipRecord& clip) {
  writer.PutText(clip.id);
  writer.PutText(clip.label);
  writer.PutText(clip.subject);
  writer.PutText(clip.title);
  writer.PutText(clip.description);
  PutTagsAndFields(writer, clip);
  writer.Put(clip.revision);
  writer.Put(clip.edit_time_us);
}

ClipRecord GetClipState(FieldReader& reader) {
  ClipRecord clip;
  clip.id = reader.GetText();
  clip.label = reader.GetText();
  clip.subject = reader.GetText();
  clip.title = reader.GetText();
  clip.description = reader.GetText();
  GetTagsAndFields(reader, clip);
  clip.revision = reader.Get<std::int64_t>();
  clip.edit_time_us = reader.Get<std::int64_t>();
  return clip;
}

void PutState(FieldWriter& writer, const SegmentRecord& segment) {
  writer.PutText(segment.clip);
  writer.PutText(segment.id);
  writer.PutText(segment.track);
  writer.PutText(segment.label);
  writer.Put(segment.start_seconds);
  PutFlag(writer, segment.end_seconds.has_value());
  if (segment.end_seconds) writer.Put(*segment.end_seconds);
  writer.Put(static_cast<std::uint8_t>(segment.source));
  writer.Put(segment.confidence);
  writer.Put(segment.revision);
  writer.PutText(segment.author);
  writer.Put(segment.create_time_us);
  writer.Put(segment.update_time_us);
}

SegmentRecord GetSegmentState(FieldReader& reader) {
  SegmentRecord segment;
  segment.clip = reader.GetText();
  segment.id = reader.GetText();
  segment.track = reader.GetText();
  segment.label = reader.GetText();
  segment.start_seconds = reader.Get<double>();
  if (GetFlag(reader)) segment.end_seconds = reader.Get<double>();
  const auto source = reader.Get<std::uint8_t>();
  if (reader.ok() && (source < 1 || source > 3)) {
    reader.Fail(core::DataLoss("unknown source {} of a segment", source));
  }
  segment.source = static_cast<SegmentSource>(source);
  segment.confidence = reader.Get<double>();
  segment.revision = reader.Get<std::int64_t>();
  segment.author = reader.GetText();
  segment.create_time_us = reader.Get<std::int64_t>();
  segment.update_time_us = reader.Get<std::int64_t>();
  return segment;
}

EditedState GetState(FieldReader& reader, ObjectKind kind, const std::string& database) {
  if (kind == ObjectKind::kClip) {
    ClipRecord clip = GetClipState(reader);
    clip.database = database;
    return clip;
  }
  SegmentRecord segment = GetSegmentState(reader);
  segment.database = database;
  return segment;
}

EditedObject GetObject(FieldReader& reader, const std::string& database) {
  EditedObject object;
  const auto kind = reader.Get<std::uint8_t>();
  const auto states = reader.Get<std::uint8_t>();
  if (!reader.ok()) return object;
  if (kind > 1 || states < 1 || states > 3) {
    reader.Fail(core::DataLoss("unknown kind {} of an object, or states {}", kind, states));
    return object;
  }
  if (states & kHasBefore) object.before = GetState(reader, ObjectKind{kind}, database);
  if (states & kHasAfter) object.after = GetState(reader, ObjectKind{kind}, database);
  return object;
}

void CheckVersion(FieldReader& reader) {
  const auto version = reader.Get<std::uint8_t>();
  if (reader.ok() && version != kVersion) {
    reader.Fail(core::DataLoss("expected version {}, got {}", kVersion, version));
  }
}

}  // namespace

absl::StatusOr<std::string> EncodeAnnotations(const ClipRecord& clip) {
  StringSink sink;
  FieldWriter writer(sink);
  writer.Put(kVersion);
  PutTagsAndFields(writer, clip);
  MOTIONDB_RETURN_IF_ERROR(writer.status());
  return sink.bytes();
}

absl::Status DecodeAnnotations(std::span<const std::byte> bytes, ClipRecord& clip) {
  SpanSource source(bytes);
  FieldReader reader(source);
  CheckVersion(reader);
  GetTagsAndFields(reader, clip);
  return reader.Finish();
}

absl::StatusOr<std::string> EncodeObjects(std::span<const EditedObject> objects) {
  StringSink sink;
  FieldWriter writer(sink);
  writer.Put(kVersion);
  writer.PutCount(objects.size());
  for (const EditedObject& object : objects) {
    const auto& any = object.after ? object.after : object.before;
    const bool is_clip = std::holds_alternative<ClipRecord>(*any);
    writer.Put(static_cast<std::uint8_t>(is_clip ? ObjectKind::kClip : ObjectKind::kSegment));
    writer.Put(static_cast<std::uint8_t>((object.before ? kHasBefore : 0) |
                                         (object.after ? kHasAfter : 0)));
    const auto put = [&](const auto& state) { PutState(writer, state); };
    if (object.before) std::visit(put, *object.before);
    if (object.after) std::visit(put, *object.after);
  }
  MOTIONDB_RETURN_IF_ERROR(writer.status());
  return sink.bytes();
}

absl::StatusOr<std::vector<EditedObject>> DecodeObjects(const std::string& database,
                                                        std::span<const std::byte> bytes) {
  SpanSource source(bytes);
  FieldReader reader(source);
  CheckVersion(reader);
  std::vector<EditedObject> objects;
  const std::size_t count = reader.GetCount(kObjectBytes);
  for (std::size_t i = 0; i < count && reader.ok(); ++i) {
    objects.push_back(GetObject(reader, database));
  }
  MOTIONDB_RETURN_IF_ERROR(reader.Finish());
  return objects;
}

}  // namespace motiondb::storage
