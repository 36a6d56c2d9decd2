// Orders of lists, as in https://google.aip.dev/132: `duration desc, name`.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "server/filter/filter.h"
#include "server/filter/filter_field.h"

namespace motiondb::server {

inline constexpr std::size_t kMaxOrderBytes = 1000;
inline constexpr std::size_t kMaxOrderFields = 10;

// Orders items by keys: byte strings that compare like the items, and of which no two items have
// the same. The key of the last item of a page is the position of the next page. It holds when the
// item was changed or deleted, so no other item is skipped or listed twice. Absent values are
// first, then, in fields of the user, truth values, numbers, times and texts. Texts compare
// bytewise.
class ListOrder {
 public:
  // By name. Segments: by clip, track and start.
  explicit ListOrder(FilterSubject subject);

  // Parses fields, each with `desc` or `asc` if wanted; ties are in order of name. Empty: the order
  // above. INVALID_ARGUMENT of the field `order_by` with the byte (from 1).
  static absl::StatusOr<ListOrder> Parse(std::string_view order_by, FilterSubject subject);

  // Whether clips are in the order of a catalog.
  bool is_by_clip_id() const { return terms_.empty(); }
  // The order in one form of writing, for the scope of a page token.
  std::string Text() const;

  // Appends the key of a clip, or of a segment of it, to `key`. `segment` is null in lists of
  // clips.
  void AppendKey(const CatalogClip& clip, const CatalogSegment* segment, std::string& key) const;
  std::string KeyOf(const CatalogClip& clip, const CatalogSegment* segment = nullptr) const;

 private:
  struct Term {
    std::string name;
    ResolvedField field;
    bool is_descending = false;
  };

  std::vector<Term> terms_;
};

}  // namespace motiondb::server
