#include "server/filter/filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/format/file_format.h"
#include "core/motion/error.h"
#include "server/filter/syntax.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::int64_t kStepsOfPredicate = 8;

std::int64_t PredicateCount(const Predicate& predicate) {
  std::int64_t count = 1;
  for (const Predicate& child : predicate.children) count += PredicateCount(child);
  return count;
}

// Relates the tree of a filter to fields and checks the types of its values.

constexpr std::size_t kMaxShownValueBytes = 40;
constexpr std::string_view kSources[] = {"person", "import", "suggestion"};

// A comparison of one field, as it is written.
struct Comparison {
  std::string_view name;  // of the field
  ResolvedField field;
  Comparator comparator = Comparator::kEqual;
  FilterText value;
  std::size_t value_position = 0;

  bool is_has() const { return comparator == Comparator::kHas; }
  bool is_equality() const { return comparator == Comparator::kEqual; }
};

absl::Status WrongValue(const Comparison& comparison, std::string_view expected,
                        std::string_view suggestion = "") {
  return FilterError(
      comparison.value_position,
      fmt::format("expected {} for '{}', got '{}'{}", expected, comparison.name,
                  text::TruncateUtf8(comparison.value.text, kMaxShownValueBytes), suggestion));
}

absl::Status CheckName(const Comparison& comparison, std::span<const std::string_view> names) {
  if (std::find(names.begin(), names.end(), comparison.value.text) != names.end()) {
    return absl::OkStatus();
  }
  return WrongValue(comparison, fmt::format("one of {}", fmt::join(names, ", ")),
                    Suggestion(comparison.value.text, names));
}

// Sets the value of a test. INVALID_ARGUMENT if it has another type than the field.
absl::Status SetValue(const Comparison& comparison, FieldTest& test) {
  const std::string& text = comparison.value.text;
  const FieldKind kind = comparison.field.kind;
  const bool is_any_text =
      kind == FieldKind::kText || kind == FieldKind::kLongText || kind == FieldKind::kUserField;
  test.pattern = TextPattern(comparison.value, comparison.is_has() && is_any_text);
  test.text = text;
  switch (kind) {
    case FieldKind::kNumber:
      test.number = ParseFilterNumber(text);
      if (!test.number.has_value()) return WrongValue(comparison, "a number");
      break;
    case FieldKind::kDuration:
      test.number = ParseFilterDuration(text);
      if (!test.number.has_value()) return WrongValue(comparison, "seconds as 2.5s or 2.5");
      break;
    case FieldKind::kTime:
      test.time = ParseFilterTime(text);
      if (!test.time.has_value()) {
        return WrongValue(comparison, "a date as 2026-05-01 or a time as \"2026-05-01T12:00:00Z\"");
      }
      break;
    case FieldKind::kFormat: {
      std::vector<std::string_view> names;
      for (const core::FormatInfo& info : core::KnownFormats()) names.push_back(info.name);
      return CheckName(comparison, names);
    }
    case FieldKind::kSource:
      return CheckName(comparison, kSources);
    case FieldKind::kUserField:  // the stored value decides the type
      test.time = ParseFilterTime(text);
      if (comparison.value.is_quoted) break;
      test.number = ParseFilterNumber(text);
      test.flag = ParseFilterFlag(text);
      break;
    case FieldKind::kText:
      if (comparison.field.field == FilterField::kClipId && text.starts_with("databases/")) {
        return WrongValue(comparison, "the last part of the clip's name");
      }
      break;
    default:
      break;
  }
  return absl::OkStatus();
}

// The comparators of a kind of field; `:` is always one.
bool IsComparatorOf(FieldKind kind, Comparator comparator) {
  const bool is_equality = comparator == Comparator::kEqual || comparator == Comparator::kNotEqual;
  switch (kind) {
    case FieldKind::kLongText:
      return comparator == Comparator::kHas;
    case FieldKind::kTextList:
    case FieldKind::kFormat:
    case FieldKind::kSource:
      return is_equality || comparator == Comparator::kHas;
    default:
      return true;
  }
}

// A clip passes if a segment of track `action` has the label. A clip without such a segment has the
// empty label.
Predicate LabelTest(FieldTest test) {
  test.field = {FilterField::kSegmentLabel, FieldKind::kText};
  FieldTest on_action{.field = {FilterField::kSegmentTrack, FieldKind::kText}};
  on_action.pattern = TextPattern({.text = storage::kActionTrack}, false);
  const CatalogClip unlabelled;
  const CatalogSegment empty_label;
  const bool passes_empty = Holds(TestOf(test), unlabelled, &empty_label);

  Predicate with_label =
      AnySegment(Combination(Predicate::Kind::kAnd, {TestOf(std::move(test)), TestOf(on_action)}));
  if (!passes_empty) return with_label;
  return Combination(Predicate::Kind::kOr,
                     {std::move(with_label), Negation(AnySegment(TestOf(std::move(on_action))))});
}

absl::StatusOr<Predicate> CompileComparison(Comparison comparison, std::size_t position) {
  const FieldKind kind = comparison.field.kind;
  const bool is_presence = comparison.is_has() && comparison.value.is_only_wildcard();
  if (kind == FieldKind::kSegment) {
    if (!is_presence) {
      return FilterError(position, "expected segment:* or segment:(...) with fields of segments");
    }
    return AnySegment(Predicate{});
  }
  if (kind == FieldKind::kUserField && comparison.field.user_field.empty() && !is_presence) {
    auto field = ResolveField("fields." + comparison.value.text, FieldScope::kClip);
    if (!comparison.is_has() || std::holds_alternative<std::string>(field)) {
      return FilterError(position, "expected fields.NAME, fields:NAME or fields:*");
    }
    return TestOf({.field = std::get<ResolvedField>(std::move(field)),
                   .comparator = Comparator::kHas,
                   .is_presence = true});
  }
  if (!IsComparatorOf(kind, comparison.comparator)) {
    return FilterError(position,
                       fmt::format("expected {} after '{}', got '{}'",
                                   kind == FieldKind::kLongText ? "':'" : "=, != or ':'",
                                   comparison.name, ComparatorText(comparison.comparator)));
  }
  const bool is_label = comparison.field.field == FilterField::kLabel;
  const bool is_list =
      is_label || kind == FieldKind::kTextList || comparison.field.is_of_any_segment;
  if (is_list && comparison.comparator == Comparator::kNotEqual) {  // no element is equal
    comparison.comparator = Comparator::kEqual;
    MOTIONDB_ASSIGN_OR_RETURN(Predicate equal, CompileComparison(std::move(comparison), position));
    return Negation(std::move(equal));
  }
  FieldTest test{
      .field = comparison.field, .comparator = comparison.comparator, .is_presence = is_presence};
  if (!is_presence) MOTIONDB_RETURN_IF_ERROR(SetValue(comparison, test));
  if (is_label) return LabelTest(std::move(test));
  Predicate tested = TestOf(std::move(test));
  return comparison.field.is_of_any_segment ? AnySegment(std::move(tested)) : tested;
}

// A value without a field: a text that one of some fields contains.
absl::StatusOr<Predicate> CompileSearch(const FilterText& value, std::size_t position,
                                        FieldScope scope) {
  if (!value.is_quoted) {
    constexpr std::pair<std::string_view, std::string_view> kOperators[] = {
        {"and", "AND"}, {"And", "AND"}, {"&&", "AND"},  {"or", "OR"},
        {"Or", "OR"},   {"||", "OR"},   {"not", "NOT"}, {"Not", "NOT"}};
    for (const auto& [got, expected] : kOperators) {
      if (value.text != got) continue;
      return FilterError(
          position, fmt::format("expected {} or \"{}\" with quotes, got '{}'", expected, got, got));
    }
  }
  const bool is_of_clip = scope == FieldScope::kClip;
  constexpr std::string_view kOfClip[] = {"name", "label", "title", "tags"};
  constexpr std::string_view kOfSegment[] = {"label", "clip"};
  const std::span<const std::string_view> names =
      is_of_clip ? std::span<const std::string_view>(kOfClip) : kOfSegment;
  std::vector<Predicate> tests;
  for (const std::string_view name : names) {
    FieldTest test{.field = std::get<ResolvedField>(ResolveField(name, scope)),
                   .comparator = Comparator::kHas,
                   .pattern = TextPattern(value, true)};
    const bool is_label = test.field.field == FilterField::kLabel;
    tests.push_back(is_label ? LabelTest(std::move(test)) : TestOf(std::move(test)));
  }
  return Combination(Predicate::Kind::kOr, std::move(tests));
}

// Returns the field of a comparison.
absl::StatusOr<Comparison> FieldOf(const FilterSyntax& node, const std::string& name,
                                   FieldScope scope) {
  auto field = ResolveField(name, scope);
  if (const auto* expected = std::get_if<std::string>(&field)) {
    return FilterError(node.position, fmt::format("expected {}", *expected));
  }
  return Comparison{.name = name,
                    .field = std::get<ResolvedField>(std::move(field)),
                    .comparator = *node.comparator,
                    .value = node.value,
                    .value_position = node.value_position};
}

absl::StatusOr<Predicate> CompileNode(const FilterSyntax& node, FieldScope scope);

absl::StatusOr<Predicate> CompileParts(const FilterSyntax& node, const auto& compile) {
  std::vector<Predicate> parts;
  for (const FilterSyntax& child : node.children) {
    MOTIONDB_ASSIGN_OR_RETURN(Predicate part, compile(child));
    parts.push_back(std::move(part));
  }
  if (node.kind == FilterSyntax::Kind::kNot) return Negation(std::move(parts[0]));
  return Combination(
      node.kind == FilterSyntax::Kind::kAnd ? Predicate::Kind::kAnd : Predicate::Kind::kOr,
      std::move(parts));
}

// Compares a field with several values: `label = (walk OR run)`.
absl::StatusOr<Predicate> CompileValues(const FilterSyntax& node, const Comparison& outer) {
  if (node.kind != FilterSyntax::Kind::kRestriction) {
    return CompileParts(node,
                        [&](const FilterSyntax& child) { return CompileValues(child, outer); });
  }
  if (node.comparator.has_value()) {
    return FilterError(node.position, fmt::format("expected only values between the parentheses "
                                                  "after '{}'",
                                                  outer.name));
  }
  Comparison one = outer;
  one.value = JoinedPath(node.path);
  one.value_position = node.position;
  return CompileComparison(std::move(one), node.position);
}

absl::StatusOr<Predicate> CompileRestriction(const FilterSyntax& node, FieldScope scope) {
  const FilterText path = JoinedPath(node.path);
  if (!node.comparator.has_value()) return CompileSearch(path, node.position, scope);
  MOTIONDB_ASSIGN_OR_RETURN(Comparison comparison, FieldOf(node, path.text, scope));
  if (node.children.empty()) return CompileComparison(std::move(comparison), node.position);
  if (comparison.field.kind == FieldKind::kSegment && comparison.is_has()) {
    MOTIONDB_ASSIGN_OR_RETURN(Predicate of_segment,
                              CompileNode(node.children[0], FieldScope::kSegmentOfClip));
    return AnySegment(std::move(of_segment));
  }
  if (!comparison.is_equality() && !comparison.is_has()) {
    return FilterError(node.value_position,
                       fmt::format("expected one value after '{}'; only = and ':' take several",
                                   ComparatorText(comparison.comparator)));
  }
  return CompileValues(node.children[0], comparison);
}

absl::StatusOr<Predicate> CompileNode(const FilterSyntax& node, FieldScope scope) {
  if (node.kind == FilterSyntax::Kind::kRestriction) return CompileRestriction(node, scope);
  return CompileParts(node, [&](const FilterSyntax& child) { return CompileNode(child, scope); });
}

// INVALID_ARGUMENT with the byte for an unknown field, a comparator that the field does not have,
// or a value of another type.
absl::StatusOr<Predicate> CompileFilter(const FilterSyntax& syntax, FieldScope scope) {
  return CompileNode(syntax, scope);
}

}  // namespace

absl::StatusOr<Filter> Filter::Parse(std::string_view text, FilterSubject subject) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto syntax, ParseFilterSyntax(text));
  Filter filter;
  if (!syntax.has_value()) return filter;
  const FieldScope scope =
      subject == FilterSubject::kClips ? FieldScope::kClip : FieldScope::kSegment;
  MOTIONDB_ASSIGN_OR_RETURN(Predicate predicate, CompileFilter(*syntax, scope));
  filter.step_count_ = kStepsOfPredicate * PredicateCount(predicate);
  filter.predicate_ = std::make_shared<const Predicate>(std::move(predicate));
  filter.text_ = PrintFilter(*syntax);
  return filter;
}

}  // namespace motiondb::server
