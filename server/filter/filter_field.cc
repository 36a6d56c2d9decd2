#include "server/filter/filter_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "server/filter/filter_value.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr FieldInfo kClipFields[] = {
    {"name", FilterField::kClipId, FieldKind::kText},
    {"label", FilterField::kLabel, FieldKind::kText},
    {"subject", FilterField::kSubject, FieldKind::kText},
    {"title", FilterField::kTitle, FieldKind::kText},
    {"description", FilterField::kDescription, FieldKind::kLongText},
    {"tags", FilterField::kTags, FieldKind::kTextList},
    {"fields", FilterField::kUserField, FieldKind::kUserField},
    {"create_time", FilterField::kCreateTime, FieldKind::kTime},
    {"update_time", FilterField::kUpdateTime, FieldKind::kTime},
    {"duration", FilterField::kDuration, FieldKind::kDuration},
    {"frames", FilterField::kFrames, FieldKind::kNumber},
    {"format", FilterField::kFormat, FieldKind::kFormat},
    {"file_name", FilterField::kFileName, FieldKind::kText},
    {"take", FilterField::kTake, FieldKind::kText},
    {"source", FilterField::kSegmentSource, FieldKind::kSource},
    {"track", FilterField::kSegmentTrack, FieldKind::kText},
    {"segment", FilterField::kSegment, FieldKind::kSegment},
};

constexpr FieldInfo kSegmentFields[] = {
    {"name", FilterField::kSegmentId, FieldKind::kText},
    {"clip", FilterField::kClipId, FieldKind::kText},
    {"track", FilterField::kSegmentTrack, FieldKind::kText},
    {"label", FilterField::kSegmentLabel, FieldKind::kText},
    {"start", FilterField::kSegmentStart, FieldKind::kDuration},
    {"end", FilterField::kSegmentEnd, FieldKind::kDuration},
    {"duration", FilterField::kSegmentDuration, FieldKind::kDuration},
    {"source", FilterField::kSegmentSource, FieldKind::kSource},
    {"confidence", FilterField::kSegmentConfidence, FieldKind::kNumber},
    {"author", FilterField::kSegmentAuthor, FieldKind::kText},
    {"create_time", FilterField::kSegmentCreateTime, FieldKind::kTime},
    {"update_time", FilterField::kSegmentUpdateTime, FieldKind::kTime},
};

constexpr std::string_view kUserFieldPrefix = "fields.";
constexpr std::string_view kSegmentPrefix = "segment.";
constexpr std::string_view kClipPrefix = "clip.";
constexpr std::size_t kMaxUserFieldBytes = 63;

std::span<const FieldInfo> FieldsOf(FieldScope scope) {
  if (scope == FieldScope::kClip) return kClipFields;
  return kSegmentFields;
}

bool IsUserFieldName(std::string_view name) {
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  return !name.empty() && name.size() <= kMaxUserFieldBytes && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

bool IsOfSegment(FilterField field) { return field > FilterField::kSegment; }

// All names of a scope, also those behind a dot.
std::vector<std::string> NamesOf(FieldScope scope) {
  std::vector<std::string> names;
  for (const FieldInfo& info : FieldsOf(scope)) names.emplace_back(info.name);
  if (scope == FieldScope::kClip) {
    for (const FieldInfo& info : kSegmentFields) {
      names.push_back(fmt::format("{}{}", kSegmentPrefix, info.name));
    }
  } else if (scope == FieldScope::kSegment) {
    for (const FieldInfo& info : kClipFields) {
      names.push_back(fmt::format("{}{}", kClipPrefix, info.name));
    }
  }
  return names;
}

std::string UnknownField(std::string_view name, FieldScope scope) {
  const std::vector<std::string> names = NamesOf(scope);
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  return fmt::format("a field of {}, got '{}'{}", scope == FieldScope::kClip ? "clips" : "segments",
                     text::TruncateUtf8(name, kMaxUserFieldBytes), Suggestion(name, candidates));
}

// Number of insertions, deletions and replacements that make one word of another.
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row[b.size()];
}

// How different two names are. A name is similar to its part after the last dot, and to a part at
// its beginning.
std::size_t Difference(std::string_view word, std::string_view candidate) {
  const auto last_part = [](std::string_view name) { return name.substr(name.rfind('.') + 1); };
  if (word == last_part(candidate) || last_part(word) == candidate) return 0;
  const bool is_part = word.starts_with(candidate) || candidate.starts_with(word);
  if (word.size() > 2 && is_part && last_part(word) == word) return 1;
  return EditDistance(word, candidate);
}

FieldContent UserContent(const CatalogClip& clip, const std::string& name) {
  const auto found = clip.fields.find(name);
  if (found == clip.fields.end()) return {};
  return std::visit(
      [](const auto& value) -> FieldContent {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string>) {
          return std::string_view(value);
        } else {
          return value;
        }
      },
      found->second);
}

FieldContent SegmentContent(FilterField field, const CatalogClip& clip,
                            const CatalogSegment& segment) {
  using storage::FieldTime;
  switch (field) {
    case FilterField::kSegmentId:
      return std::string_view(segment.id);
    case FilterField::kSegmentTrack:
      return std::string_view(segment.track);
    case FilterField::kSegmentLabel:
      return std::string_view(segment.label);
    case FilterField::kSegmentStart:
      return segment.start_seconds;
    case FilterField::kSegmentEnd:
      return EndSeconds(clip, segment);
    case FilterField::kSegmentDuration:
      return EndSeconds(clip, segment) - segment.start_seconds;
    case FilterField::kSegmentSource:
      return SegmentSourceText(segment.source);
    case FilterField::kSegmentConfidence:
      return segment.confidence;
    case FilterField::kSegmentAuthor:
      return std::string_view(segment.author);
    case FilterField::kSegmentCreateTime:
      return FieldTime{segment.create_time_us};
    case FilterField::kSegmentUpdateTime:
      return FieldTime{segment.update_time_us};
    default:
      return {};
  }
}

}  // namespace

std::variant<ResolvedField, std::string> ResolveField(std::string_view name, FieldScope scope) {
  if (scope == FieldScope::kSegment && name.starts_with(kClipPrefix)) {
    return ResolveField(name.substr(kClipPrefix.size()), FieldScope::kClip);
  }
  if (scope == FieldScope::kClip && name.starts_with(kUserFieldPrefix)) {
    const std::string_view user_field = name.substr(kUserFieldPrefix.size());
    if (!IsUserFieldName(user_field)) {
      return fmt::format("a name of a-z, 0-9 and '_' after 'fields.', got '{}'",
                         text::TruncateUtf8(user_field, kMaxUserFieldBytes));
    }
    return ResolvedField{FilterField::kUserField, FieldKind::kUserField, std::string(user_field)};
  }
  const bool has_prefix = scope == FieldScope::kClip && name.starts_with(kSegmentPrefix);
  const FieldScope found_in = has_prefix ? FieldScope::kSegmentOfClip : scope;
  const std::string_view rest = has_prefix ? name.substr(kSegmentPrefix.size()) : name;
  for (const FieldInfo& info : FieldsOf(found_in)) {
    if (info.name != rest) continue;
    ResolvedField field(info.field, info.kind);
    field.is_of_any_segment = has_prefix || (scope == FieldScope::kClip && IsOfSegment(info.field));
    return field;
  }
  return UnknownField(name, scope);
}

FieldContent ContentOf(const ResolvedField& field, const CatalogClip& clip,
                       const CatalogSegment* segment) {
  using storage::FieldTime;
  if (segment != nullptr && IsOfSegment(field.field)) {
    return SegmentContent(field.field, clip, *segment);
  }
  switch (field.field) {
    case FilterField::kClipId:
      return std::string_view(clip.id);
    case FilterField::kLabel:
      for (const CatalogSegment& each : clip.segments) {
        if (each.is_on_action_track()) return std::string_view(each.label);
      }
      return std::string_view();
    case FilterField::kSubject:
      return std::string_view(clip.subject);
    case FilterField::kTitle:
      return std::string_view(clip.title);
    case FilterField::kDescription:
      return std::string_view(clip.description);
    case FilterField::kUserField:
      return UserContent(clip, field.user_field);
    case FilterField::kCreateTime:
      return FieldTime{clip.create_time_us};
    case FilterField::kUpdateTime:
      if (clip.edit_time_us == 0) return {};
      return FieldTime{clip.edit_time_us};
    case FilterField::kDuration:
      return clip.duration_seconds;
    case FilterField::kFrames:
      return static_cast<double>(clip.frame_count);
    case FilterField::kFormat:
      return core::InfoOf(clip.format).name;
    case FilterField::kFileName:
      return std::string_view(clip.file_name);
    case FilterField::kTake:
      return std::string_view(clip.take);
    default:
      return {};
  }
}

std::string Suggestion(std::string_view word, std::span<const std::string_view> candidates) {
  std::string_view best;
  if (word.size() > kMaxUserFieldBytes) return "";
  std::size_t least = word.size() < 4 ? 2 : std::max<std::size_t>(word.size() / 3, 2) + 1;
  for (const std::string_view candidate : candidates) {
    const std::size_t difference = Difference(word, candidate);
    if (difference >= least) continue;
    least = difference;
    best = candidate;
  }
  return best.empty() ? "" : fmt::format("; did you mean '{}'?", best);
}

}  // namespace motiondb::server
