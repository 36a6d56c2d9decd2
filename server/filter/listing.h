// Pages of clips and segments of a catalog.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "server/filter/catalog.h"
#include "server/filter/facets.h"
#include "server/filter/filter.h"
#include "server/filter/list_order.h"

namespace motiondb::server {

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
