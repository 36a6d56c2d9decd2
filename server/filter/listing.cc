#include "server/filter/listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/filter/filter_value.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

constexpr std::string_view kFacetFields[] = {"label", "subject", "tags",
                                             "track", "format",  "source"};
constexpr std::string_view kUserFacetPrefix = "fields.";

// Text of a value of a field of the user.
std::string ContentText(const FieldContent& content) {
  if (const auto* number = std::get_if<double>(&content)) return fmt::format("{}", *number);
  if (const auto* flag = std::get_if<bool>(&content)) return *flag ? "true" : "false";
  if (const auto* time = std::get_if<storage::FieldTime>(&content)) return TimeText(time->time_us);
  return "";
}

}  // namespace

absl::StatusOr<std::vector<FacetField>> ParseFacets(const std::vector<std::string>& names) {
  if (names.size() > kMaxFacets) {
    return core::FieldViolation("facets", "expected at most {} fields, got {}", kMaxFacets,
                                names.size());
  }
  std::vector<FacetField> facets;
  for (const std::string& name : names) {
    auto field = ResolveField(name, FieldScope::kClip);
    const bool is_known = std::count(std::begin(kFacetFields), std::end(kFacetFields), name) > 0 ||
                          name.starts_with(kUserFacetPrefix);
    if (!is_known || std::holds_alternative<std::string>(field)) {
      return core::FieldViolation("facets", "expected {} or fields.NAME, got '{}'{}",
                                  fmt::join(kFacetFields, ", "), text::TruncateUtf8(name, 80),
                                  Suggestion(name, kFacetFields));
    }
    facets.push_back({name, std::get<ResolvedField>(std::move(field))});
  }
  return facets;
}

void FacetCounter::Count(std::string_view value) {
  if (!value.empty()) ++counts_[value];
}

void FacetCounter::CountTextOf(const FieldContent& content) {
  if (const auto* text = std::get_if<std::string_view>(&content)) return Count(*text);
  std::string text = ContentText(content);
  if (counts_.count(text) == 0) {
    texts_.push_back(std::move(text));
    return Count(texts_.back());
  }
  Count(text);
}

void FacetCounter::Add(const CatalogClip& clip) {
  const ResolvedField& field = field_.field;
  if (field.kind == FieldKind::kTextList) {
    for (const std::string& tag : clip.tags) Count(tag);
    return;
  }
  const bool is_label = field.field == FilterField::kLabel;
  if (!is_label && !field.is_of_any_segment) return CountTextOf(ContentOf(field, clip, nullptr));
  const ResolvedField of_segment =
      is_label ? ResolvedField{FilterField::kSegmentLabel, FieldKind::kText} : field;
  of_clip_.clear();
  for (const CatalogSegment& segment : clip.segments) {
    if (is_label && !segment.is_on_action_track()) continue;
    of_clip_.push_back(std::get<std::string_view>(ContentOf(of_segment, clip, &segment)));
  }
  std::sort(of_clip_.begin(), of_clip_.end());
  of_clip_.erase(std::unique(of_clip_.begin(), of_clip_.end()), of_clip_.end());
  for (const std::string_view value : of_clip_) Count(value);
}

Facet FacetCounter::Counts() const {
  std::vector<std::pair<std::string_view, int>> sorted(counts_.begin(), counts_.end());
  const auto count = static_cast<std::ptrdiff_t>(std::min(sorted.size(), kMaxFacetValues));
  std::partial_sort(sorted.begin(), sorted.begin() + count, sorted.end(),
                    [](const auto& a, const auto& b) {
                      return a.second != b.second ? a.second > b.second : a.first < b.first;
                    });
  Facet facet{.field = field_.name};
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    facet.values.push_back({std::string(sorted[static_cast<std::size_t>(i)].first),
                            sorted[static_cast<std::size_t>(i)].second});
  }
  return facet;
}

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
