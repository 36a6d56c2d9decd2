#include "server/filter/listing.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

absl::Status ListCancelled() { return absl::CancelledError("the list was cancelled"); }

// Keeps the items with the least keys after a position.
template <typename Item>
class FirstItems {
 public:
  explicit FirstItems(const ListPart& part) : part_(part) {}

  // Returns the key of the next item to add.
  std::string& NextKey() {
    key_.clear();
    return key_;
  }
  void Add(const Item& item) {
    if (part_.limit == 0 || key_ <= part_.after) return;
    if (items_.size() < part_.limit) {
      items_.emplace_back(key_, item);
      std::push_heap(items_.begin(), items_.end(), IsBefore);
    } else if (key_ < items_.front().first) {
      std::pop_heap(items_.begin(), items_.end(), IsBefore);
      items_.back().first.swap(key_);
      items_.back().second = item;
      std::push_heap(items_.begin(), items_.end(), IsBefore);
    }
  }
  std::vector<Item> InOrder() && {
    std::sort_heap(items_.begin(), items_.end(), IsBefore);
    std::vector<Item> items;
    for (const auto& [key, item] : items_) items.push_back(item);
    return items;
  }

 private:
  using Keyed = std::pair<std::string, Item>;
  static bool IsBefore(const Keyed& a, const Keyed& b) { return a.first < b.first; }

  const ListPart& part_;
  std::string key_;
  std::vector<Keyed> items_;  // a heap
};

}  // namespace

absl::StatusOr<ListedClips> ListClips(const Catalog& catalog, const Filter& filter,
                                      const ListOrder& order, const ListPart& part,
                                      std::span<const FacetField> facets,
                                      const core::Cancelled& cancelled) {
  ListedClips listed;
  std::vector<FacetCounter> counters(facets.begin(), facets.end());
  FirstItems<const CatalogClip*> first(part);
  core::ThrottledCancellation cancellation(cancelled);
  bool is_cancelled = false;
  catalog.ForEach([&](const CatalogClip& clip) {
    is_cancelled = cancellation.cancelled(filter.StepsFor(clip));
    if (!filter.Passes(clip)) return !is_cancelled;
    ++listed.total_count;
    for (FacetCounter& counter : counters) counter.Add(clip);
    if (order.is_by_clip_id()) {
      if (listed.clips.size() < part.limit && clip.id > part.after) listed.clips.push_back(&clip);
    } else {
      order.AppendKey(clip, nullptr, first.NextKey());
      first.Add(&clip);
    }
    return !is_cancelled;
  });
  if (is_cancelled) return ListCancelled();
  if (!order.is_by_clip_id()) listed.clips = std::move(first).InOrder();
  for (const FacetCounter& counter : counters) listed.facets.push_back(counter.Counts());
  return listed;
}

absl::StatusOr<ListedSegments> ListSegments(const Catalog& catalog, const std::string& clip,
                                            const Filter& filter, const ListOrder& order,
                                            const ListPart& part,
                                            const core::Cancelled& cancelled) {
  ListedSegments listed;
  FirstItems<ListedSegment> first(part);
  core::ThrottledCancellation cancellation(cancelled);
  bool is_cancelled = false;
  const auto add_segments_of = [&](const CatalogClip& each) {
    is_cancelled = cancellation.cancelled(filter.StepsFor(each));
    for (const CatalogSegment& segment : each.segments) {
      if (!filter.Passes(each, segment)) continue;
      ++listed.total_count;
      order.AppendKey(each, &segment, first.NextKey());
      first.Add({&each, &segment});
    }
    return !is_cancelled;
  };
  if (clip.empty()) {
    catalog.ForEach(add_segments_of);
  } else {
    const CatalogClip* found = catalog.Find(clip);
    if (found == nullptr) return core::NotFound("clip {} not found", clip);
    add_segments_of(*found);
  }
  if (is_cancelled) return ListCancelled();
  listed.segments = std::move(first).InOrder();
  return listed;
}

}  // namespace motiondb::server
