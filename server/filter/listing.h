// Pages of clips and segments of a catalog, and counts of the values of fields of clips.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "server/filter/catalog.h"
#include "server/filter/filter.h"
#include "server/filter/filter_field.h"
#include "server/filter/list_order.h"

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

// Which part of a list to return.
struct ListPart {
  std::string after =
      {};  // key of the item before the first one (ListOrder); empty: from the start
  std::size_t limit = 100;
};

struct ListedClips {
  std::vector<const CatalogClip*> clips;  // hold as long as the catalog
  std::size_t total_count = 0;            // of all pages
  std::vector<Facet> facets;              // of all pages, as asked for
};

// Lists the clips that pass a filter. CANCELLED. O(number of clips), and for another order than by
// name O(clips that pass * log(limit)).
absl::StatusOr<ListedClips> ListClips(const Catalog& catalog, const Filter& filter,
                                      const ListOrder& order, const ListPart& part,
                                      std::span<const FacetField> facets = {},
                                      const core::Cancelled& cancelled = {});

struct ListedSegment {
  const CatalogClip* clip = nullptr;
  const CatalogSegment* segment = nullptr;
};

struct ListedSegments {
  std::vector<ListedSegment> segments;  // hold as long as the catalog
  std::size_t total_count = 0;
};

// Lists the segments of one clip (`clip` not empty; NOT_FOUND), or of all, that pass a filter.
// CANCELLED. O(number of segments + segments that pass * log(limit)).
absl::StatusOr<ListedSegments> ListSegments(const Catalog& catalog, const std::string& clip,
                                            const Filter& filter, const ListOrder& order,
                                            const ListPart& part,
                                            const core::Cancelled& cancelled = {});

}  // namespace motiondb::server
