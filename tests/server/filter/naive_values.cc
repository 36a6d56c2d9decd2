#include "tests/server/filter/naive_values.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "core/format/file_format.h"

namespace motiondb::tests {
namespace {

using storage::FieldTime;
using storage::FieldValue;

bool Globs(const char* text, const char* end, const NaiveLiteral& literal, std::size_t from) {
  if (from == literal.text.size()) return text == end;
  if (literal.is_wildcard[from]) {
    for (const char* rest = text; rest <= end; ++rest) {
      if (Globs(rest, end, literal, from + 1)) return true;
    }
    return false;
  }
  return text != end && *text == literal.text[from] && Globs(text + 1, end, literal, from + 1);
}

bool Globs(const std::string& text, const NaiveLiteral& literal) {
  return Globs(text.data(), text.data() + text.size(), literal, 0);
}

std::string Lower(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 128) c = static_cast<char>(std::tolower(c));
  }
  return text;
}

const char* SourceName(storage::SegmentSource source) {
  if (source == storage::SegmentSource::kPerson) return "person";
  return source == storage::SegmentSource::kImport ? "import" : "suggestion";
}

double EndOf(const StoredClip& clip, const storage::SegmentRecord& segment) {
  return segment.end_seconds ? *segment.end_seconds : clip.record.duration_seconds;
}

NaiveField One(FieldValue value) { return {.values = {std::move(value)}}; }

NaiveField SegmentField(const std::string& name, const StoredClip& clip,
                        const storage::SegmentRecord& segment) {
  if (name == "name") return One(segment.id);
  if (name == "clip") return One(segment.clip);
  if (name == "track") return One(segment.track);
  if (name == "label") return One(segment.label);
  if (name == "start") return One(segment.start_seconds);
  if (name == "end") return One(EndOf(clip, segment));
  if (name == "duration") return One(EndOf(clip, segment) - segment.start_seconds);
  if (name == "confidence") return One(segment.confidence);
  if (name == "author") return One(segment.author);
  if (name == "create_time") return One(FieldTime{segment.create_time_us});
  if (name == "update_time") return One(FieldTime{segment.update_time_us});
  NaiveField source = One(std::string(SourceName(segment.source)));
  source.is_exact = true;
  return source;
}

// The values of a field in all segments.
NaiveField OfSegments(const std::string& name, const StoredClip& clip, bool only_action = false) {
  NaiveField field{.is_list = true};
  for (const auto& segment : clip.segments) {
    if (only_action && segment.track != "action") continue;
    const NaiveField one = SegmentField(name, clip, segment);
    field.is_exact = one.is_exact;
    field.values.push_back(one.values[0]);
  }
  return field;
}

NaiveField ClipField(const std::string& name, const StoredClip& clip) {
  const storage::ClipRecord& record = clip.record;
  if (name == "name") return One(record.id);
  if (name == "subject") return One(record.subject);
  if (name == "title") return One(record.title);
  if (name == "description") return One(record.description);
  if (name == "file_name") return One(record.file_name);
  if (name == "take") return One(record.given.take);
  if (name == "duration") return One(record.duration_seconds);
  if (name == "frames") return One(static_cast<double>(record.frame_count));
  if (name == "create_time") return One(FieldTime{record.create_time_us});
  if (name == "update_time") {
    return record.edit_time_us == 0 ? NaiveField{} : One(FieldTime{record.edit_time_us});
  }
  if (name == "format") {
    NaiveField format = One(std::string(core::InfoOf(record.format).name));
    format.is_exact = true;
    return format;
  }
  if (name == "tags") {
    return {.is_list = true,
            .is_exact = true,
            .values = std::vector<FieldValue>(record.tags.begin(), record.tags.end())};
  }
  if (name == "label") {
    NaiveField labels = OfSegments("label", clip, true);
    if (labels.values.empty()) labels.values.emplace_back(std::string());
    return labels;
  }
  if (name == "source" || name == "track") return OfSegments(name, clip);
  if (name.starts_with("segment.")) return OfSegments(name.substr(8), clip);
  const auto found = record.fields.find(name.substr(7));
  NaiveField field{.is_presence_of_key = true};
  if (found != record.fields.end()) field.values.push_back(found->second);
  return field;
}

template <typename T>
bool Orders(const std::string& comparator, const T& a, const T& b) {
  if (comparator == "<") return a < b;
  if (comparator == "<=") return a <= b;
  if (comparator == ">") return a > b;
  return a >= b;
}

std::optional<double> NumberOf(const NaiveLiteral& literal) {
  std::string text = literal.text;
  if (text.size() > 1 && text.back() == 's') text.pop_back();
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') return std::nullopt;
  return number;
}

// Whether the comparison is possible, and if so its result.
std::optional<bool> CompareOne(const std::string& comparator, const NaiveField& field,
                               const FieldValue& value, const NaiveLiteral& literal) {
  const bool is_of_user = field.is_presence_of_key;
  const bool is_equality = comparator == "=" || comparator == ":" || comparator == "!=";
  if (const auto* text = std::get_if<std::string>(&value)) {
    if (!is_equality) return Orders(comparator, *text, literal.text);
    if (comparator == ":" && !field.is_exact) return NaiveContains(*text, literal);
    return Globs(*text, literal) == (comparator != "!=");
  }
  if (const auto* flag = std::get_if<bool>(&value)) {
    const bool is_flag = literal.text == "true" || literal.text == "false";
    if (!is_flag || literal.is_quoted || !is_equality) return std::nullopt;
    return (*flag == (literal.text == "true")) == (comparator != "!=");
  }
  if (const auto* number = std::get_if<double>(&value)) {
    const auto to = NumberOf(literal);
    if (!to || (is_of_user && (literal.is_quoted || literal.text.back() == 's'))) {
      return std::nullopt;
    }
    if (is_equality) return (*number == *to) == (comparator != "!=");
    return Orders(comparator, *number, *to);
  }
  if (!literal.times_us) return std::nullopt;
  const auto [begin, end] = *literal.times_us;
  const std::int64_t time = std::get<FieldTime>(value).time_us;
  const bool is_in = begin <= time && time < end;
  if (is_equality) return is_in == (comparator != "!=");
  if (is_in) return comparator == "<=" || comparator == ">=";
  return Orders(comparator, time, begin);
}

}  // namespace

bool NaiveContains(const std::string& text, const NaiveLiteral& literal) {
  NaiveLiteral pattern{.text = "*" + Lower(literal.text) + "*"};
  pattern.is_wildcard = literal.is_wildcard;
  pattern.is_wildcard.insert(pattern.is_wildcard.begin(), true);
  pattern.is_wildcard.push_back(true);
  return Globs(Lower(text), pattern);
}

NaiveField NaiveFieldOf(const std::string& name, const StoredClip& clip,
                        const storage::SegmentRecord* segment) {
  if (segment == nullptr) return ClipField(name, clip);
  if (name.starts_with("clip.")) return ClipField(name.substr(5), clip);
  return SegmentField(name, clip, *segment);
}

bool NaiveCompare(const std::string& comparator, const NaiveField& field,
                  const NaiveLiteral& literal) {
  if (comparator == "*") {
    return std::any_of(field.values.begin(), field.values.end(), [&](const FieldValue& value) {
      return field.is_presence_of_key || value != FieldValue(std::string());
    });
  }
  if (comparator == "!=" && field.is_list) return !NaiveCompare("=", field, literal);
  return std::any_of(field.values.begin(), field.values.end(), [&](const FieldValue& value) {
    return CompareOne(comparator, field, value, literal).value_or(false);
  });
}

}  // namespace motiondb::tests
