#include "server/filter/predicate.h"

#include <algorithm>
#include <utility>

namespace motiondb::server {
namespace {

template <typename T>
bool Compare(Comparator comparator, const T& value, const T& to) {
  switch (comparator) {
    case Comparator::kEqual:
    case Comparator::kHas:
      return value == to;
    case Comparator::kNotEqual:
      return value != to;
    case Comparator::kLess:
      return value < to;
    case Comparator::kLessEqual:
      return value <= to;
    case Comparator::kGreater:
      return value > to;
    case Comparator::kGreaterEqual:
      return value >= to;
  }
  return false;
}

bool PassesText(const FieldTest& test, std::string_view value) {
  switch (test.comparator) {
    case Comparator::kEqual:
    case Comparator::kHas:
      return test.pattern.Matches(value);
    case Comparator::kNotEqual:
      return !test.pattern.Matches(value);
    default:
      return Compare<std::string_view>(test.comparator, value, test.text);
  }
}

bool PassesTime(Comparator comparator, std::int64_t time_us, const TimeRange& range) {
  switch (comparator) {
    case Comparator::kEqual:
    case Comparator::kHas:
      return time_us >= range.begin_us && time_us < range.end_us;
    case Comparator::kNotEqual:
      return time_us < range.begin_us || time_us >= range.end_us;
    case Comparator::kLess:
      return time_us < range.begin_us;
    case Comparator::kLessEqual:
      return time_us < range.end_us;
    case Comparator::kGreater:
      return time_us >= range.end_us;
    case Comparator::kGreaterEqual:
      return time_us >= range.begin_us;
  }
  return false;
}

bool IsOrder(Comparator comparator) {
  return comparator != Comparator::kEqual && comparator != Comparator::kNotEqual &&
         comparator != Comparator::kHas;
}

// Applies a test to a value of each type.
struct ValueTest {
  const FieldTest& test;

  bool operator()(std::monostate) const { return false; }
  bool operator()(std::string_view value) const {
    return test.is_presence ? !value.empty() : PassesText(test, value);
  }
  bool operator()(double value) const {
    return test.is_presence ||
           (test.number.has_value() && Compare(test.comparator, value, *test.number));
  }
  bool operator()(bool value) const {
    return test.is_presence || (test.flag.has_value() && !IsOrder(test.comparator) &&
                                Compare(test.comparator, value, *test.flag));
  }
  bool operator()(storage::FieldTime value) const {
    return test.is_presence ||
           (test.time.has_value() && PassesTime(test.comparator, value.time_us, *test.time));
  }
};

bool Passes(const FieldTest& test, const CatalogClip& clip, const CatalogSegment* segment) {
  if (test.field.field == FilterField::kTags) {
    return std::any_of(clip.tags.begin(), clip.tags.end(),
                       [&](const std::string& tag) { return ValueTest{test}(tag); });
  }
  if (test.field.field == FilterField::kUserField && test.is_presence) {
    const std::string& name = test.field.user_field;
    return name.empty() ? !clip.fields.empty() : clip.fields.count(name) > 0;
  }
  return std::visit(ValueTest{test}, ContentOf(test.field, clip, segment));
}

}  // namespace

Predicate TestOf(FieldTest test) {
  return {.kind = Predicate::Kind::kTest,
          .test = std::make_shared<const FieldTest>(std::move(test))};
}

Predicate Negation(Predicate predicate) {
  Predicate negation{.kind = Predicate::Kind::kNot};
  negation.children.push_back(std::move(predicate));
  return negation;
}

Predicate AnySegment(Predicate of_segment) {
  Predicate any{.kind = Predicate::Kind::kAnySegment};
  any.children.push_back(std::move(of_segment));
  return any;
}

Predicate Combination(Predicate::Kind kind, std::vector<Predicate> children) {
  return {.kind = kind, .children = std::move(children)};
}

bool Holds(const Predicate& predicate, const CatalogClip& clip, const CatalogSegment* segment) {
  const auto holds = [&](const Predicate& child) { return Holds(child, clip, segment); };
  const std::vector<Predicate>& children = predicate.children;
  switch (predicate.kind) {
    case Predicate::Kind::kTrue:
      return true;
    case Predicate::Kind::kAnd:
      return std::all_of(children.begin(), children.end(), holds);
    case Predicate::Kind::kOr:
      return std::any_of(children.begin(), children.end(), holds);
    case Predicate::Kind::kNot:
      return !Holds(children[0], clip, segment);
    case Predicate::Kind::kAnySegment:
      return std::any_of(
          clip.segments.begin(), clip.segments.end(),
          [&](const CatalogSegment& each) { return Holds(children[0], clip, &each); });
    case Predicate::Kind::kTest:
      return Passes(*predicate.test, clip, segment);
  }
  return false;
}

}  // namespace motiondb::server
