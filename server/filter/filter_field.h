// The fields of clips and segments in filters and orders. docs/filters.md lists them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "server/filter/catalog_clip.h"

namespace motiondb::server {

enum class FilterField {
  kClipId,
  kLabel,  // of the segments of track `action`
  kSubject,
  kTitle,
  kDescription,
  kTags,
  kUserField,
  kCreateTime,
  kUpdateTime,
  kDuration,
  kFrames,
  kFormat,
  kFileName,
  kTake,
  kSegment,  // the segments of a clip
  kSegmentId,
  kSegmentTrack,
  kSegmentLabel,
  kSegmentStart,
  kSegmentEnd,
  kSegmentDuration,
  kSegmentSource,
  kSegmentConfidence,
  kSegmentAuthor,
  kSegmentCreateTime,
  kSegmentUpdateTime,
};

enum class FieldKind {
  kText,
  kLongText,  // only `:`
  kTextList,  // only =, != and `:`
  kNumber,
  kDuration,
  kTime,
  kFormat,  // only =, != and `:`
  kSource,  // likewise
  kUserField,
  kSegment
};

// The object that a field belongs to.
enum class FieldScope {
  kClip,
  kSegment,       // in a list of segments: `clip.` leads to the clip
  kSegmentOfClip  // between the parentheses of `segment:(...)`
};

struct FieldInfo {
  std::string_view name;
  FilterField field;
  FieldKind kind;
};

// A field as a filter or order names it.
struct ResolvedField {
  ResolvedField(FilterField of_field, FieldKind of_kind, std::string name = "")
      : field(of_field), kind(of_kind), user_field(std::move(name)) {}

  FilterField field;
  FieldKind kind;
  std::string user_field;  // kUserField: its name; empty: `fields` itself
  // A field of a segment that a filter of clips names: that of any segment.
  bool is_of_any_segment = false;
};

// Returns the field with this name; or what is wrong: "a field of clips, got 'lable'; did you mean
// 'label'?".
std::variant<ResolvedField, std::string> ResolveField(std::string_view name, FieldScope scope);

// Value of a field with one value.
using FieldContent =
    std::variant<std::monostate, std::string_view, double, bool, storage::FieldTime>;

// Returns the value; none if it is absent. Durations in seconds. `segment` is null for fields of
// clips. Not for kSegment and kTags; kLabel gives the label of the first segment of track `action`.
FieldContent ContentOf(const ResolvedField& field, const CatalogClip& clip,
                       const CatalogSegment* segment);

// Returns ", did you mean '...'?" with the candidate that is most similar to a word; empty if none
// is.
std::string Suggestion(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace motiondb::server
