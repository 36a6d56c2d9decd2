// Random filters: the same answers as a naive evaluation, and the same after printing.
#include <catch2/catch.hpp>

#include "server/filter/filter.h"
#include "tests/server/filter/naive_filter.h"

namespace motiondb::tests {
namespace filter_property {
namespace {

using server::Filter;
using server::FilterSubject;

struct Answers {
  int passing = 0;
  int failing = 0;

  void Add(bool passes) { ++(passes ? passing : failing); }
};

// Compares a filter with its naive evaluation on each clip, or on each segment.
void CheckFilter(const Filter& filter, FilterSubject subject, const NaiveFilter& naive,
                 const StoredClips& clips, const server::Catalog& catalog, Answers& answers) {
  for (const auto& [id, stored] : clips) {
    const server::CatalogClip* clip = catalog.Find(id);
    REQUIRE(clip != nullptr);
    if (subject == FilterSubject::kClips) {
      const bool expected = NaivePasses(naive, stored, nullptr);
      if (filter.Passes(*clip) != expected) FAIL_CHECK("clip " << id << ": " << !expected);
      answers.Add(expected);
      continue;
    }
    for (const storage::SegmentRecord& segment : stored.segments) {
      const bool expected = NaivePasses(naive, stored, &segment);
      const bool passes = filter.Passes(*clip, server::ToCatalogSegment(segment));
      if (passes != expected) FAIL_CHECK("segment " << id << "/" << segment.id << ": " << passes);
      answers.Add(expected);
    }
  }
}

TEST_CASE("Random filters pass what a naive evaluation passes") {
  Random random(20260501);
  StoredClips clips;
  for (int i = 0; i < 60; ++i) {
    const std::string id = "c" + std::to_string(i);
    clips[id] = RandomStoredClip(random, id);
  }
  const server::Catalog catalog = CatalogOf(clips);
  Answers answers;
  for (int i = 0; i < 6000; ++i) {
    const FilterSubject subject = i % 2 == 0 ? FilterSubject::kClips : FilterSubject::kSegments;
    const NaiveFilter naive = RandomFilter(random, subject, i % 4);
    const std::string text = WriteFilter(random, naive);
    CAPTURE(i, text);
    const auto filter = Filter::Parse(text, subject);
    CAPTURE(filter.status().message());
    REQUIRE(filter.ok());
    CheckFilter(*filter, subject, naive, clips, catalog, answers);

    CAPTURE(filter->text());
    const auto again = Filter::Parse(filter->text(), subject);
    CAPTURE(again.status().message());
    REQUIRE(again.ok());
    CHECK(again->text() == filter->text());
    CheckFilter(*again, subject, naive, clips, catalog, answers);
  }
  CHECK(answers.passing > 50'000);
  CHECK(answers.failing > 50'000);
}

}  // namespace
}  // namespace filter_property
}  // namespace motiondb::tests
