// Lists of clips and segments: orders compared with a sort, and pages under changes.
#include "server/filter/listing.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/filter/naive_values.h"

namespace motiondb::tests {
namespace listing {
namespace {

using server::Catalog;
using server::Filter;
using server::FilterSubject;
using server::ListOrder;
using storage::FieldValue;

StoredClips RandomClips(Random& random, int count) {
  StoredClips clips;
  for (int i = 0; i < count; ++i) {
    const std::string id = fmt::format("c{}", i);
    clips[id] = RandomStoredClip(random, id);
  }
  return clips;
}

Filter ParsedFilter(const std::string& text, FilterSubject subject = FilterSubject::kClips) {
  const auto filter = Filter::Parse(text, subject);
  REQUIRE(filter.ok());
  return *filter;
}

ListOrder ParsedOrder(const std::string& text, FilterSubject subject = FilterSubject::kClips) {
  const auto order = ListOrder::Parse(text, subject);
  CAPTURE(text, order.status().message());
  REQUIRE(order.ok());
  return *order;
}

// A field to sort by, and the direction.
using Terms = std::vector<std::pair<std::string, bool>>;

// -1, 0 or 1, as the value is before, equal to or after the other: by type, then by value.
int Compared(const NaiveField& a, const NaiveField& b) {
  constexpr int kRanks[] = {4, 2, 1, 3};  // of text, number, flag and time
  const auto rank = [&](const NaiveField& field) {
    return field.values.empty() ? 0 : kRanks[field.values[0].index()];
  };
  if (rank(a) != rank(b)) return rank(a) < rank(b) ? -1 : 1;
  if (rank(a) == 0) return 0;
  return std::visit(
      [&](const auto& left) {
        const auto& right = std::get<std::decay_t<decltype(left)>>(b.values[0]);
        if constexpr (std::is_same_v<std::decay_t<decltype(left)>, storage::FieldTime>) {
          return left.time_us < right.time_us ? -1 : left.time_us > right.time_us ? 1 : 0;
        } else {
          return left < right ? -1 : right < left ? 1 : 0;
        }
      },
      a.values[0]);
}

struct NaiveItem {
  const StoredClip* clip;
  const storage::SegmentRecord* segment;

  std::string name() const {
    return clip->record.id + (segment == nullptr ? "" : "/" + segment->id);
  }
};

// The values of `label` of a clip begin with that of its first segment in order of start.
StoredClip Sorted(StoredClip clip) {
  std::sort(clip.segments.begin(), clip.segments.end(), [](const auto& a, const auto& b) {
    return std::tie(a.track, a.start_seconds, a.id) < std::tie(b.track, b.start_seconds, b.id);
  });
  return clip;
}

std::vector<std::string> NaiveOrder(std::vector<NaiveItem> items, const Terms& terms) {
  std::sort(items.begin(), items.end(), [&](const NaiveItem& a, const NaiveItem& b) {
    for (const auto& [name, is_descending] : terms) {
      const int order =
          Compared(NaiveFieldOf(name, *a.clip, a.segment), NaiveFieldOf(name, *b.clip, b.segment));
      if (order != 0) return (order < 0) != is_descending;
    }
    if (a.clip->record.id != b.clip->record.id) return a.clip->record.id < b.clip->record.id;
    return a.segment != nullptr && a.segment->id < b.segment->id;
  });
  std::vector<std::string> names;
  for (const NaiveItem& item : items) names.push_back(item.name());
  return names;
}

std::vector<std::string> NamesOf(const server::ListedClips& listed) {
  std::vector<std::string> names;
  for (const auto* clip : listed.clips) names.push_back(clip->id);
  return names;
}

std::vector<std::string> NamesOf(const server::ListedSegments& listed) {
  std::vector<std::string> names;
  for (const auto& [clip, segment] : listed.segments) names.push_back(clip->id + "/" + segment->id);
  return names;
}

std::string TextOf(const Terms& terms) {
  std::string text;
  for (const auto& [name, is_descending] : terms) {
    text += fmt::format("{}{}{}", text.empty() ? "" : " ,", name, is_descending ? "  desc" : "");
  }
  return text;
}

Terms RandomTerms(Random& random, const std::vector<const char*>& fields) {
  Terms terms;
  for (int count = Below(random, 4); count > 0; --count) {
    terms.emplace_back(OneOf(random, fields), Below(random, 2) == 0);
  }
  return terms;
}

TEST_CASE("Pages of random orders are the sorted list") {
  Random random(3);
  StoredClips clips = RandomClips(random, 300);
  for (auto& [id, clip] : clips) clip = Sorted(std::move(clip));
  const Catalog catalog = CatalogOf(clips);
  std::vector<NaiveItem> all_clips;
  std::vector<NaiveItem> all_segments;
  for (const auto& [id, clip] : clips) {
    all_clips.push_back({&clip, nullptr});
    for (const auto& segment : clip.segments) all_segments.push_back({&clip, &segment});
  }
  for (int i = 0; i < 100; ++i) {
    const Terms terms = RandomTerms(
        random, {"name", "label", "subject", "title", "create_time", "update_time", "duration",
                 "frames", "format", "file_name", "take", "fields.x", "fields.score"});
    CAPTURE(TextOf(terms));
    const ListOrder order = ParsedOrder(TextOf(terms));
    CHECK(ParsedOrder(order.Text()).Text() == order.Text());
    std::vector<std::string> names;
    server::ListPart part{.limit = 70};
    while (true) {
      const auto page = server::ListClips(catalog, Filter(), order, part);
      REQUIRE(page.ok());
      CHECK(page->total_count == clips.size());
      if (page->clips.empty()) break;
      for (std::string& name : NamesOf(*page)) names.push_back(std::move(name));
      part.after = order.KeyOf(*page->clips.back());
    }
    CHECK(names == NaiveOrder(all_clips, terms));
  }
  for (int i = 0; i < 50; ++i) {
    Terms terms = RandomTerms(random, {"name", "clip", "track", "label", "start", "end", "duration",
                                       "source", "confidence", "author", "create_time",
                                       "update_time", "clip.subject", "clip.fields.x"});
    CAPTURE(TextOf(terms));
    const ListOrder order = ParsedOrder(TextOf(terms), FilterSubject::kSegments);
    if (terms.empty()) terms = {{"clip", false}, {"track", false}, {"start", false}};
    std::vector<std::string> names;
    server::ListPart part{.limit = 100};
    while (true) {
      const auto page = server::ListSegments(catalog, "", Filter(), order, part);
      REQUIRE(page.ok());
      CHECK(page->total_count == all_segments.size());
      if (page->segments.empty()) break;
      for (std::string& name : NamesOf(*page)) names.push_back(std::move(name));
      part.after = order.KeyOf(*page->segments.back().clip, page->segments.back().segment);
    }
    CHECK(names == NaiveOrder(all_segments, terms));
  }
}

// Other clips appear, change and vanish between the pages.
TEST_CASE("Clips that do not change are listed once under changes") {
  Random random(4);
  for (const std::string order_by : {"", "duration desc, name", "fields.x"}) {
    CAPTURE(order_by);
    const ListOrder order = ParsedOrder(order_by);
    StoredClips clips = RandomClips(random, 200);
    Catalog catalog = CatalogOf(clips);
    std::set<std::string> untouched;
    for (const auto& [id, clip] : clips) untouched.insert(id);
    std::vector<std::string> names;
    server::ListPart part{.limit = 15};
    for (std::int64_t revision = 2;; ++revision) {
      const auto page = server::ListClips(catalog, Filter(), order, part);
      REQUIRE(page.ok());
      if (page->clips.empty()) break;
      for (std::string& name : NamesOf(*page)) names.push_back(std::move(name));
      const server::CatalogClip& last = *page->clips.back();
      part.after = order.KeyOf(last);
      std::vector<storage::ChangeRecord> changes;
      const auto touch = [&](const std::string& id) {
        untouched.erase(id);
        storage::ChangeRecord& change = changes.emplace_back();
        change.revision = revision;
        if (Below(random, 2) == 0) {
          change.change = storage::Deleted{id, ""};
        } else {
          change.change = storage::ClipPut{RandomClip(random, id)};
        }
      };
      for (int i = 0; i < 3; ++i) touch(fmt::format("c{}", Below(random, 250)));
      touch(last.id);
      catalog = catalog.With(changes);
      REQUIRE(revision < 100);
    }
    CHECK(untouched.size() > 100);
    for (const std::string& id : untouched) CHECK(std::count(names.begin(), names.end(), id) == 1);
  }
}

TEST_CASE("A list has the clips that pass its filter") {
  Random random(5);
  const StoredClips clips = RandomClips(random, 300);
  const Catalog catalog = CatalogOf(clips);
  const auto listed = server::ListClips(catalog, ParsedFilter("duration > 1 AND tags:slow"),
                                        ParsedOrder("duration"), {.limit = 5});
  REQUIRE(listed.ok());
  std::size_t count = 0;
  for (const auto& [id, clip] : clips) {
    const auto& tags = clip.record.tags;
    if (clip.record.duration_seconds > 1 && std::count(tags.begin(), tags.end(), "slow") > 0)
      ++count;
  }
  CHECK(listed->total_count == count);
  CHECK(listed->clips.size() == 5);

  const auto segments =
      server::ListSegments(catalog, "c7", ParsedFilter("track = action", FilterSubject::kSegments),
                           ListOrder(FilterSubject::kSegments), {});
  REQUIRE(segments.ok());
  for (const auto& [clip, segment] : segments->segments) {
    CHECK(clip->id == "c7");
    CHECK(segment->track == "action");
  }
  const auto missing =
      server::ListSegments(catalog, "none", Filter(), ListOrder(FilterSubject::kSegments), {});
  CHECK(absl::IsNotFound(missing.status()));
}

TEST_CASE("A list can be cancelled") {
  Random random(6);
  const Catalog catalog = CatalogOf(RandomClips(random, 400));
  std::string heavy = "title:x";
  while (heavy.size() < 4000) heavy += " OR title:x";
  const auto listed = server::ListClips(
      catalog, ParsedFilter(heavy), ListOrder(FilterSubject::kClips), {}, {}, [] { return true; });
  CHECK(absl::IsCancelled(listed.status()));
}

TEST_CASE("Orders that are not accepted say where and why") {
  struct Rejected {
    const char* order_by;
    const char* message;
  };
  const Rejected kRejected[] = {
      {"durtion",
       "order_by: byte 1: expected a field of clips, got 'durtion'; did you mean 'duration'?"},
      {"name,", "order_by: byte 6: expected a field"},
      {"name, ,label", "order_by: byte 6: expected a field"},
      {"name down", "order_by: byte 6: expected desc, asc or ',', got 'down'"},
      {"name desc x", "got 'desc x'"},
      {"tags", "order_by: byte 1: expected a field with one value, got 'tags'"},
      {"label, segment.label", "order_by: byte 8: expected a field with one value"},
      {"description", "expected a field with one value"},
      {"fields", "expected a field with one value"},
      {"segment", "expected a field with one value"}};
  for (const Rejected& rejected : kRejected) {
    CAPTURE(rejected.order_by);
    const auto order = ListOrder::Parse(rejected.order_by, FilterSubject::kClips);
    CHECK(absl::IsInvalidArgument(order.status()));
    CHECK_THAT(std::string(order.status().message()), Catch::Contains(rejected.message));
  }
  CHECK(!ListOrder::Parse(std::string(2000, 'a'), FilterSubject::kClips).ok());
  std::string many = "name";
  for (int i = 0; i < 10; ++i) many += ",name";
  CHECK(!ListOrder::Parse(many, FilterSubject::kClips).ok());
  CHECK(!ListOrder::Parse("subject", FilterSubject::kSegments).ok());
  CHECK(ParsedOrder(" duration asc , name").Text() == "duration, name");
  CHECK(ParsedOrder("name").is_by_clip_id());
  CHECK(!ParsedOrder("name desc").is_by_clip_id());
}

}  // namespace
}  // namespace listing
}  // namespace motiondb::tests
