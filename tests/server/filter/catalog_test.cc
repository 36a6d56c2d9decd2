// The catalog under random changes, compared with a plain map.
#include "server/filter/catalog.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/server/filter/random_records.h"

namespace motiondb::tests {
namespace catalog {
namespace {

using server::Catalog;
using storage::ChangeRecord;

std::string Described(const storage::FieldValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return "'" + *text + "'";
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  return fmt::format("@{}", std::get<storage::FieldTime>(value).time_us);
}

// All that a catalog has of a clip, except its segments.
template <typename Clip>
std::string Described(const Clip& clip, const std::string& take) {
  std::string text = fmt::format(
      "{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}\n", clip.id, clip.subject, clip.title, clip.description,
      clip.file_name, take, static_cast<int>(clip.format), clip.frame_count, clip.duration_seconds,
      clip.create_time_us, clip.edit_time_us, fmt::join(clip.tags, ","));
  for (const auto& [name, value] : clip.fields)
    text += fmt::format("  {}={}\n", name, Described(value));
  return text;
}

template <typename Segment>
std::string DescribedSegment(const Segment& segment) {
  return fmt::format("  {}|{}|{}|{}|{}|{}|{}|{}|{}|{}\n", segment.track, segment.start_seconds,
                     segment.id, segment.label, segment.author, segment.end_seconds.value_or(-1),
                     static_cast<int>(segment.source), segment.confidence, segment.create_time_us,
                     segment.update_time_us);
}

std::string Described(const Catalog& of) {
  std::string text;
  of.ForEach([&](const server::CatalogClip& clip) {
    text += Described(clip, clip.take);
    for (const auto& segment : clip.segments) text += DescribedSegment(segment);
    return true;
  });
  return text;
}

std::string Described(const StoredClips& clips) {
  std::string text;
  for (const auto& [id, clip] : clips) {
    text += Described(clip.record, clip.record.given.take);
    std::vector<storage::SegmentRecord> segments = clip.segments;
    std::sort(segments.begin(), segments.end(), [](const auto& a, const auto& b) {
      return std::tie(a.track, a.start_seconds, a.id) < std::tie(b.track, b.start_seconds, b.id);
    });
    for (const auto& segment : segments) text += DescribedSegment(segment);
  }
  return text;
}

// Changes a random object of the clips and returns the change.
ChangeRecord RandomChange(Random& random, std::int64_t revision, StoredClips& clips) {
  const std::string id = fmt::format("c{}", Below(random, 900));
  const auto found = clips.find(id);
  const int kind = Below(random, 10);
  if (found == clips.end() || kind < 2) {
    StoredClip& clip = clips[id];
    clip.record = RandomClip(random, id);
    return {revision, storage::ClipPut{clip.record}};
  }
  std::vector<storage::SegmentRecord>& segments = found->second.segments;
  if (kind == 2) {
    clips.erase(found);
    return {revision, storage::Deleted{id, ""}};
  }
  if (kind == 3) return {revision, storage::ModelPut{7}};
  const std::string segment_id = fmt::format("s{}", Below(random, 4));
  const auto segment =
      std::find_if(segments.begin(), segments.end(),
                   [&](const storage::SegmentRecord& each) { return each.id == segment_id; });
  if (kind == 4) {
    if (segment != segments.end()) segments.erase(segment);
    return {revision, storage::Deleted{id, segment_id}};
  }
  const storage::SegmentRecord put = RandomSegment(random, id, segment_id);
  if (segment != segments.end()) {
    *segment = put;
  } else {
    segments.push_back(put);
  }
  return {revision, storage::SegmentPut{put}};
}

void CheckAmount(const Catalog& catalog, const StoredClips& clips) {
  server::StoredAmount stored;
  for (const auto& [id, clip] : clips) stored = stored + server::AmountOf(clip.record);
  CHECK(catalog.stored().clip_count == stored.clip_count);
  CHECK(catalog.stored().frame_count == stored.frame_count);
  CHECK(catalog.stored().byte_count == stored.byte_count);
}

TEST_CASE("A catalog under random changes is that of a plain map") {
  Random random(1);
  StoredClips clips;
  Catalog catalog;
  std::vector<std::pair<Catalog, std::string>> earlier;
  std::int64_t revision = 0;
  for (int step = 0; step < 400; ++step) {
    std::vector<ChangeRecord> changes;
    const int count = step % 10 == 0 ? 300 : 1 + Below(random, 5);
    for (int i = 0; i < count; ++i) changes.push_back(RandomChange(random, ++revision, clips));
    catalog = catalog.With(changes);
    CHECK(catalog.revision() == revision);
    CheckAmount(catalog, clips);
    if (step % 20 == 0) {
      const std::string described = Described(clips);
      REQUIRE(Described(catalog) == described);
      earlier.emplace_back(catalog, described);
    }
    const std::string id = fmt::format("c{}", Below(random, 900));
    CHECK((catalog.Find(id) != nullptr) == (clips.count(id) > 0));
  }
  REQUIRE(Described(catalog) == Described(clips));
  // A catalog is unchanged by later ones.
  for (const auto& [before, described] : earlier) CHECK(Described(before) == described);

  std::vector<ChangeRecord> deletions;
  for (const auto& [id, clip] : clips) deletions.emplace_back().change = storage::Deleted{id, ""};
  catalog = catalog.With(deletions);
  CheckAmount(catalog, {});
  CHECK(Described(catalog).empty());
}

TEST_CASE("A segment can precede its clip, also in an earlier call") {
  Random random(2);
  StoredClips clips;
  for (int i = 0; i < 400; ++i) {
    const std::string id = fmt::format("c{}", i);
    clips[id] = RandomStoredClip(random, id);
  }
  std::vector<ChangeRecord> changes;
  for (const auto& [id, clip] : clips) {
    for (ChangeRecord& change : ChangesOf(clip)) changes.push_back(std::move(change));
  }
  std::shuffle(changes.begin(), changes.end(), random);
  Catalog catalog;
  for (std::size_t begin = 0; begin < changes.size(); begin += 100) {
    const std::size_t count = std::min<std::size_t>(100, changes.size() - begin);
    catalog = catalog.With(std::span(changes).subspan(begin, count));
    int listed = 0;
    catalog.ForEach([&](const server::CatalogClip&) { return ++listed > 0; });
    CHECK(listed == catalog.stored().clip_count);
  }
  CHECK(Described(catalog) == Described(clips));
  CHECK(Described(catalog.With(changes)) == Described(clips));
}

TEST_CASE("A catalog without clips") {
  const Catalog empty;
  CHECK(empty.Find("a") == nullptr);
  CHECK(empty.With({}).stored().clip_count == 0);
  std::vector<ChangeRecord> changes(3);
  changes[0].change = storage::Deleted{"a", ""};
  changes[1].change = storage::Deleted{"b", "s"};
  changes[2] = ChangeRecord{5, storage::ModelPut{1}};
  CHECK(empty.With(changes).stored().clip_count == 0);
  CHECK(empty.With(changes).revision() == 5);
}

}  // namespace
}  // namespace catalog
}  // namespace motiondb::tests
