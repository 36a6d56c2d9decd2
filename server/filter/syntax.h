// Grammar of filters, https://google.aip.dev/160, without functions. OR binds tighter than AND;
// terms side by side are joined by AND. The tree is not yet related to fields.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::server {

inline constexpr std::size_t kMaxFilterBytes = 4096;
inline constexpr int kMaxFilterDepth = 32;  // of parentheses

enum class Comparator { kEqual, kNotEqual, kLess, kLessEqual, kGreater, kGreaterEqual, kHas };

// The comparator as in a filter: "<=".
std::string_view ComparatorText(Comparator comparator);

// A word or a quoted string.
struct FilterText {
  std::string text;                    // without quotes and escapes
  std::vector<std::size_t> wildcards;  // indices of each '*' in `text` that stands for any text
  bool is_quoted = false;

  bool is_only_wildcard() const { return text == "*" && wildcards.size() == 1; }
};

struct FilterSyntax {
  enum class Kind { kAnd, kOr, kNot, kRestriction };
  Kind kind = Kind::kRestriction;
  std::size_t position = 0;  // index of its first byte
  // kAnd, kOr: at least two; kNot: one; kRestriction: one if its value is in parentheses.
  std::vector<FilterSyntax> children;

  // Restrictions only.
  std::vector<FilterText> path;          // a field; without a comparator, a value to search for
  std::optional<Comparator> comparator;  // none: a bare value
  FilterText value;                      // unless there is a comparator and a child
  std::size_t value_position = 0;
};

// Returns the tree; none for an empty filter. INVALID_ARGUMENT with the byte (from 1), what was
// expected and what is there. O(size).
absl::StatusOr<std::optional<FilterSyntax>> ParseFilterSyntax(std::string_view text);

// Returns a filter with the same tree. May be longer than kMaxFilterBytes.
std::string PrintFilter(const FilterSyntax& syntax);

// Returns the path or the bare value as one text: `segment.label`.
FilterText JoinedPath(const std::vector<FilterText>& path);

// Returns INVALID_ARGUMENT of the field `filter`: "filter: byte 9: ...". `position` is an index.
absl::Status FilterError(std::size_t position, std::string_view description);

}  // namespace motiondb::server
