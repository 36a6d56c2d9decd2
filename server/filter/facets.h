// Counts of the values of fields of clips.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "server/filter/filter_field.h"

namespace motiondb::server {

inline constexpr std::size_t kMaxFacets = 10;
inline constexpr std::size_t kMaxFacetValues = 1000;

struct FacetField {
  std::string name;
  ResolvedField field;
};

// Parses label, subject, tags, track, format, source or `fields.NAME`; at most kMaxFacets.
// INVALID_ARGUMENT of the field `facets`.
absl::StatusOr<std::vector<FacetField>> ParseFacets(const std::vector<std::string>& names);

struct FacetValue {
  std::string value;
  int clip_count = 0;
};

struct Facet {
  std::string field;
  // Most frequent first, then by value; at most kMaxFacetValues.
  std::vector<FacetValue> values;
};

// Counts the clips with each value of one field. A clip with a value several times counts once, one
// without a value or with an empty one does not count. For one thread; the clips must outlive it.
class FacetCounter {
 public:
  explicit FacetCounter(FacetField field) : field_(std::move(field)) {}

  void Add(const CatalogClip& clip);
  Facet Counts() const;

 private:
  void Count(std::string_view value);
  void CountTextOf(const FieldContent& content);

  FacetField field_;
  std::unordered_map<std::string_view, int> counts_;
  std::deque<std::string> texts_;          // of numbers, times and truth values
  std::vector<std::string_view> of_clip_;  // values of the segments of one clip
};

}  // namespace motiondb::server
