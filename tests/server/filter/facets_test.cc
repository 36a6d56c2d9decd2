// Facets, compared with naive counts.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "server/filter/filter_value.h"
#include "server/filter/listing.h"
#include "tests/server/filter/naive_values.h"

namespace motiondb::tests {
namespace facets {
namespace {

using server::FilterSubject;

std::string AsText(const storage::FieldValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  return server::TimeText(std::get<storage::FieldTime>(value).time_us);
}

TEST_CASE("Facets count clips as a naive count does") {
  Random random(7);
  StoredClips clips;
  for (int i = 0; i < 500; ++i) {
    const std::string id = fmt::format("c{}", i);
    clips[id] = RandomStoredClip(random, id);
  }
  const server::Catalog catalog = CatalogOf(clips);
  const std::vector<std::string> names = {"label",  "subject", "tags",     "track",
                                          "format", "source",  "fields.x", "fields.none"};
  const auto parsed = server::ParseFacets(names);
  REQUIRE(parsed.ok());
  const auto filter = server::Filter::Parse("duration > 0.5", FilterSubject::kClips);
  REQUIRE(filter.ok());
  const auto listed = server::ListClips(catalog, *filter, server::ListOrder(FilterSubject::kClips),
                                        {.limit = 0}, *parsed);
  REQUIRE(listed.ok());
  CHECK(listed->clips.empty());
  REQUIRE(listed->facets.size() == names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    CAPTURE(names[i]);
    std::map<std::string, int> counts;
    for (const auto& [id, clip] : clips) {
      if (clip.record.duration_seconds <= 0.5) continue;
      std::set<std::string> values;
      for (const auto& value : NaiveFieldOf(names[i], clip, nullptr).values) {
        values.insert(AsText(value));
      }
      for (const std::string& value : values) counts[value] += value.empty() ? 0 : 1;
    }
    counts.erase("");
    std::vector<std::pair<int, std::string>> expected;
    for (const auto& [value, count] : counts) expected.emplace_back(-count, value);
    std::sort(expected.begin(), expected.end());
    std::vector<std::pair<int, std::string>> counted;
    for (const auto& value : listed->facets[i].values) {
      counted.emplace_back(-value.clip_count, value.value);
    }
    CHECK(listed->facets[i].field == names[i]);
    CHECK(counted == expected);
  }
}

TEST_CASE("A facet has at most 1,000 values, the most frequent ones") {
  StoredClips clips;
  for (int i = 0; i < 1500; ++i) {
    StoredClip clip;
    clip.record.id = fmt::format("c{:04}", i);
    clip.record.subject = i % 2 == 0 ? "often" : fmt::format("s{:04}", i);
    clips[clip.record.id] = clip;
  }
  for (int i = 0; i < 1500; ++i) {
    StoredClip clip;
    clip.record.id = fmt::format("d{:04}", i);
    clip.record.subject = fmt::format("t{:04}", i);
    clips[clip.record.id] = clip;
  }
  const std::vector<std::string> names = {"subject"};
  const auto parsed = server::ParseFacets(names);
  REQUIRE(parsed.ok());
  const auto listed = server::ListClips(CatalogOf(clips), server::Filter(),
                                        server::ListOrder(FilterSubject::kClips), {}, *parsed);
  REQUIRE(listed.ok());
  const auto& values = listed->facets[0].values;
  REQUIRE(values.size() == server::kMaxFacetValues);
  CHECK(values[0].value == "often");
  CHECK(values[0].clip_count == 750);
  CHECK(values[1].value == "s0001");
}

TEST_CASE("Other facets are rejected") {
  for (const char* name :
       {"title", "Label", "fields", "fields.", "fields.X", "segment.label", ""}) {
    CAPTURE(name);
    const std::vector<std::string> names = {name};
    CHECK(absl::IsInvalidArgument(server::ParseFacets(names).status()));
  }
  const std::vector<std::string> misspelled = {"lable"};
  CHECK(std::string(server::ParseFacets(misspelled).status().message()) ==
        "facets: expected label, subject, tags, track, format, source or fields.NAME, got 'lable'; "
        "did you mean 'label'?");
  CHECK(!server::ParseFacets(std::vector<std::string>(11, "label")).ok());
}

}  // namespace
}  // namespace facets
}  // namespace motiondb::tests
