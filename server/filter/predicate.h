// The compiled form of a filter.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "server/filter/catalog_clip.h"
#include "server/filter/filter_field.h"
#include "server/filter/filter_value.h"

namespace motiondb::server {

// A comparison of one field with a value. A value that is absent or has another type passes none,
// also not !=.
struct FieldTest {
  ResolvedField field;  // kTags: !kNotEqual; not kLabel, not kSegment
  Comparator comparator = Comparator::kEqual;
  bool is_presence = false;  // there is a value; of a text: not an empty one
  // The value in each type that it can have.
  TextPattern pattern;  // of =, != and `:`
  std::string text;     // of the other comparators
  std::optional<double> number;
  std::optional<bool> flag;
  std::optional<TimeRange> time;
};

struct Predicate {
  enum class Kind { kTrue, kAnd, kOr, kNot, kAnySegment, kTest };
  Kind kind = Kind::kTrue;
  std::vector<Predicate> children;        // kNot, kAnySegment: one
  std::shared_ptr<const FieldTest> test;  // kTest only
};

Predicate TestOf(FieldTest test);
Predicate Negation(Predicate predicate);
Predicate AnySegment(Predicate of_segment);
Predicate Combination(Predicate::Kind kind, std::vector<Predicate> children);

// Whether a clip, or a segment of it, passes. `segment` is null at a clip.
bool Holds(const Predicate& predicate, const CatalogClip& clip, const CatalogSegment* segment);

}  // namespace motiondb::server
