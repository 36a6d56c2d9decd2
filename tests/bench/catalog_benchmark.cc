// Measures lists of 100,000 clips with 150,000 segments: filters that 10 clips pass, orders, facets
// and changes. The limit is a plain loop over a vector of structs with only the compared fields.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "server/filter/listing.h"

namespace motiondb::tests {
namespace {

using server::Catalog;
using server::Filter;
using server::FilterSubject;
using server::ListOrder;

constexpr int kClips = 100'000;
constexpr int kPassing = 10;

bool IsRare(int i) { return i % (kClips / kPassing) == 77; }

std::vector<storage::ChangeRecord> Changes() {
  constexpr const char* kLabels[] = {"walk", "run", "jump", "boxing", "climb stairs", "sit"};
  std::vector<storage::ChangeRecord> changes;
  for (int i = 0; i < kClips; ++i) {
    storage::ClipRecord clip;
    clip.id = fmt::format("session_{:03}_take_{:05}", i % 200, i);
    clip.subject = fmt::format("{:02}", i % 97);
    clip.title = fmt::format("Take {} of session {}", i, i % 200);
    clip.file_name = clip.id + ".bvh";
    clip.duration_seconds = 1 + (i * 7919 % 3000) / 100.0;
    clip.frame_count = static_cast<std::int32_t>(clip.duration_seconds * 60);
    clip.create_time_us = 1'700'000'000'000'000 + i * std::int64_t{60'000'000};
    clip.tags = {"left", i % 3 == 0 ? "slow" : "usual"};
    clip.fields["score"] = static_cast<double>(i % 100);
    changes.emplace_back().change = storage::ClipPut{clip};
    for (int j = 0; j <= i % 2; ++j) {
      storage::SegmentRecord segment;
      segment.clip = clip.id;
      segment.id = fmt::format("s{}", j);
      segment.label = IsRare(i) ? "cartwheel" : kLabels[(i + j) % 6];
      segment.track = j == 0 ? storage::kActionTrack : "carries";
      changes.emplace_back().change = storage::SegmentPut{segment};
    }
  }
  return changes;
}

std::size_t UsedBytes() { return mallinfo2().uordblks; }

struct Loaded {
  Catalog catalog;
  std::size_t bytes = 0;
};

const Loaded& All() {
  static const Loaded kLoaded = [] {
    const std::vector<storage::ChangeRecord> changes = Changes();
    const std::size_t before = UsedBytes();
    Loaded loaded{.catalog = Catalog().With(changes)};
    loaded.bytes = UsedBytes() - before;
    return loaded;
  }();
  return kLoaded;
}

// Ends the program at an error: a benchmark has no caller to report to.
template <typename T>
T Checked(absl::StatusOr<T> result) {
  if (result.ok()) return *std::move(result);
  std::fprintf(stderr, "%s\n", std::string(result.status().message()).c_str());
  std::exit(1);
}

void ListFiltered(benchmark::State& state, const std::string& text, const std::string& order_by,
                  std::size_t expected) {
  const Catalog& catalog = All().catalog;
  std::size_t count = 0;
  for (auto _ : state) {
    const Filter filter = Checked(Filter::Parse(text, FilterSubject::kClips));
    const ListOrder order = Checked(ListOrder::Parse(order_by, FilterSubject::kClips));
    count = Checked(server::ListClips(catalog, filter, order, {})).total_count;
  }
  if (count != expected) state.SkipWithError("the filter passes another number of clips");
  state.counters["clips"] = static_cast<double>(count);
}

void ListFacets(benchmark::State& state) {
  const std::vector<std::string> names = {"label", "subject", "tags", "track", "fields.score"};
  const auto facets = Checked(server::ParseFacets(names));
  for (auto _ : state) {
    const auto listed =
        server::ListClips(All().catalog, Filter(), ListOrder(FilterSubject::kClips), {}, facets);
    benchmark::DoNotOptimize(listed.ok());
  }
}

void ListRareSegments(benchmark::State& state) {
  const Filter filter =
      Checked(Filter::Parse("label = cartwheel AND clip.subject:*", FilterSubject::kSegments));
  const ListOrder order(FilterSubject::kSegments);
  for (auto _ : state) {
    const auto listed = server::ListSegments(All().catalog, "", filter, order, {});
    benchmark::DoNotOptimize(listed.ok());
  }
}

struct PlainClip {
  std::string label;
  double duration_seconds = 0;
};

void PlainLoop(benchmark::State& state) {
  std::vector<PlainClip> clips;
  for (int i = 0; i < kClips; ++i) {
    clips.push_back({IsRare(i) ? "cartwheel" : i % 2 == 0 ? "walk" : "climb stairs", i * 0.1});
  }
  for (auto _ : state) {
    std::vector<const PlainClip*> passing;
    for (const PlainClip& clip : clips) {
      if (clip.label == "cartwheel") passing.push_back(&clip);
    }
    benchmark::DoNotOptimize(passing.data());
  }
}

void ChangeOne(benchmark::State& state) {
  Catalog catalog = All().catalog;
  std::vector<storage::ChangeRecord> changes(1);
  storage::SegmentRecord segment;
  segment.id = "s0";
  segment.label = "changed";
  int i = 0;
  for (auto _ : state) {
    i = (i + 7919) % kClips;
    segment.clip = fmt::format("session_{:03}_take_{:05}", i % 200, i);
    changes[0].change = storage::SegmentPut{segment};
    catalog = catalog.With(changes);
  }
}

void Load(benchmark::State& state) {
  const std::vector<storage::ChangeRecord> changes = Changes();
  for (auto _ : state) benchmark::DoNotOptimize(Catalog().With(changes).stored().clip_count);
  state.counters["bytes_per_clip"] = static_cast<double>(All().bytes) / kClips;
}

}  // namespace
}  // namespace motiondb::tests

int main(int argc, char** argv) {
  using namespace motiondb::tests;
  benchmark::Initialize(&argc, argv);
  const auto add = [](const std::string& name, auto function, auto... arguments) {
    benchmark::RegisterBenchmark(name.c_str(), function, arguments...)
        ->Unit(benchmark::kMillisecond);
  };
  const std::string rare = "label = cartwheel";
  add("plain_loop", PlainLoop);
  add("list/label", ListFiltered, rare, "", std::size_t{kPassing});
  add("list/label_by_duration", ListFiltered, rare, "duration desc", std::size_t{kPassing});
  add("list/duration_and_subject_and_label", ListFiltered,
      "duration > 1s AND subject != \"xx\" AND label = cartwheel", "", std::size_t{kPassing});
  add("list/search", ListFiltered, std::string("CARTWHEEL"), "", std::size_t{kPassing});
  add("list/field", ListFiltered, "fields.score >= 0 AND " + rare, "", std::size_t{kPassing});
  add("list/one_segment", ListFiltered,
      std::string("segment:(label = cartwheel AND track = action)"), "", std::size_t{kPassing});
  add("list/all", ListFiltered, "", "", std::size_t{kClips});
  add("list/all_by_duration", ListFiltered, "", "duration desc", std::size_t{kClips});
  add("list/all_by_title", ListFiltered, "", "title", std::size_t{kClips});
  add("facets", ListFacets);
  add("segments/label", ListRareSegments);
  add("change", ChangeOne);
  add("load", Load);
  benchmark::RunSpecifiedBenchmarks();
}
