#include "core/model/label_units.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <set>

#include "core/model/label_tracks.h"
#include "core/model/model.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::label_units_test {
namespace {

core::ModelClip ClipOf(int first_frame, int frames, core::LabelTracks labels) {
  return {"", std::move(labels), first_frame, frames, 1, ""};
}

core::LabelTracks Spans(std::vector<core::LabelSpan> spans, const std::string& track) {
  core::LabelTracks labels;
  labels.Set(track, std::move(spans));
  return labels;
}

using core::IndexPair;

// Returns one unit for each label; empty: no label.
std::vector<core::LabelUnit> UnitsOf(const std::vector<std::string>& labels) {
  std::vector<core::ModelClip> clips;
  for (const std::string& label : labels) clips.push_back({"", label, 0, 1, 1, ""});
  return core::LabelUnits(clips, 60, core::kActionTrack).all();
}

double Cost(const core::FrameMatrix& observed, const core::FrameMatrix& reference, int i, int j) {
  return (observed.row(i) - reference.row(j)).cast<double>().squaredNorm();
}

// Returns the minimum cost of all paths from (i, j).
double MinCostFrom(const core::FrameMatrix& observed, const core::FrameMatrix& reference, int i,
                   int j) {
  if (j >= reference.rows()) return std::numeric_limits<double>::infinity();
  const double here = Cost(observed, reference, i, j);
  if (i + 1 == observed.rows()) return here;
  double min_cost = std::numeric_limits<double>::infinity();
  for (int step = 0; step <= 2; ++step) {
    min_cost = std::min(min_cost, MinCostFrom(observed, reference, i + 1, j + step));
  }
  return here + min_cost;
}

}  // namespace

TEST_CASE("LabelUnits: a clip with one label is one unit", "[core][model]") {
  const std::vector<core::ModelClip> clips = {ClipOf(0, 9, "walk"), ClipOf(9, 4, ""),
                                              ClipOf(13, 5, Spans({{"jog", 0, 5}}, "action"))};
  const core::LabelUnits units(clips, 60, core::kActionTrack);
  CHECK(units.labels() == std::vector<std::string>{"jog", "walk"});
  const auto rows = core::StrideFrames(clips, 60);
  REQUIRE(units.all().size() == 3);
  const int labels[] = {1, -1, 0};
  for (int c = 0; c < 3; ++c) {
    const core::LabelUnit& unit = units.of_clip(c).front();
    CHECK(unit.clip == c);
    CHECK(unit.label == labels[c]);
    CHECK(unit.first_frame == clips[c].first_frame);
    CHECK(unit.frame_count == clips[c].frame_count);
    CHECK(unit.rows.first == rows.begin[c]);
    CHECK(unit.rows.count == rows.count(c));
  }
  CHECK(units.NameOf(-1).empty());
  CHECK(clips[0].label() == "walk");
  CHECK(clips[1].label().empty());
  CHECK(clips[2].label() == "jog");
}

TEST_CASE("LabelUnits: spans and the gaps between them partition the frames", "[core][model]") {
  std::mt19937 random(3);
  for (const double rate : {25.0, 60.0, 120.0}) {
    std::vector<core::ModelClip> clips;
    int first = 0;
    for (int c = 0; c < 30; ++c) {
      const int frames = 1 + static_cast<int>(random() % 60);
      std::vector<core::LabelSpan> spans;
      for (int next = static_cast<int>(random() % 4); next < frames;) {
        const int count = std::min<int>(1 + static_cast<int>(random() % 12), frames - next);
        spans.push_back({std::string(1, static_cast<char>('a' + random() % 5)), next, count});
        next += count + static_cast<int>(random() % 3);
      }
      clips.push_back(ClipOf(first, frames, Spans(spans, "other")));
      CHECK(clips.back().labels.Check(frames).ok());
      first += frames;
    }
    const core::LabelUnits units(clips, rate, "other");
    const auto rows = core::StrideFrames(clips, rate);
    int next = 0;
    for (const core::LabelUnit& unit : units.all()) {
      CHECK(unit.first_frame == next);
      REQUIRE(unit.frame_count > 0);
      next += unit.frame_count;
      const core::ModelClip& clip = clips[unit.clip];
      std::string label;
      for (const core::LabelSpan& span : clip.labels.Of("other")) {
        const int at = unit.first_frame - clip.first_frame;
        if (at >= span.first_frame && at < span.first_frame + span.frame_count) label = span.label;
      }
      CHECK(units.NameOf(unit.label) == label);
      // Its strided frames, or the one before it if it has none.
      REQUIRE(unit.rows.count > 0);
      for (int r = unit.rows.first; r < unit.rows.first + unit.rows.count; ++r) {
        CHECK((rows.frame[r] < next));
        CHECK((rows.frame[r] >= unit.first_frame || unit.rows.count == 1));
        CHECK(rows.frame[r] >= clip.first_frame);
      }
    }
    CHECK(next == first);
    const core::LabelUnits action(clips, rate, core::kActionTrack);
    CHECK(action.labels().empty());
    CHECK(action.all().size() == clips.size());
    CHECK(action.other_tracks() == std::vector<std::string>{"other"});
  }
}

TEST_CASE("LabelTracks: refuses spans that overlap, are empty or outside the clip",
          "[core][model]") {
  const auto is_valid = [](std::vector<core::LabelSpan> spans) {
    return Spans(std::move(spans), "hands").Check(10).ok();
  };
  CHECK(is_valid({{"a", 0, 10}}));
  CHECK(is_valid({{"a", 0, 5}, {"b", 5, 5}}));
  CHECK_FALSE(is_valid({{"a", 0, 5}, {"b", 4, 5}}));
  CHECK_FALSE(is_valid({{"a", 5, 5}, {"b", 0, 5}}));
  CHECK_FALSE(is_valid({{"a", 0, 11}}));
  CHECK_FALSE(is_valid({{"a", -1, 5}}));
  CHECK_FALSE(is_valid({{"a", 2, 0}}));
  CHECK_FALSE(is_valid({{"", 2, 3}}));
  CHECK_FALSE(is_valid({{"a", 2147483647, 2147483647}}));
  core::LabelTracks whole = "walk";
  whole.Resolve(10);
  CHECK(whole == Spans({{"walk", 0, 10}}, core::kActionTrack));
  CHECK(whole.Whole(10) == "walk");
  CHECK(whole.Whole(11).empty());
}

TEST_CASE("AlignFrames: finds the path with the lowest cost", "[core][model]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const int dimensions = 3;
    const core::FrameMatrix observed = WanderingStates(6, dimensions, seed);
    const core::FrameMatrix reference =
        WanderingStates(3 + static_cast<int>(seed % 7), dimensions, seed + 100);
    double min_cost = std::numeric_limits<double>::infinity();
    for (int start = 0; start < 4; ++start) {
      min_cost = std::min(min_cost,
                          0.05 * dimensions * start + MinCostFrom(observed, reference, 0, start));
    }
    const auto pairs = core::AlignFrames(observed, reference);
    REQUIRE(pairs.size() == 6);
    double cost = 0.05 * dimensions * pairs.front().reference;
    for (int i = 0; i < 6; ++i) {
      REQUIRE(pairs[i].observed == i);
      if (i > 0) {
        CHECK(pairs[i].reference >= pairs[i - 1].reference);
        CHECK(pairs[i].reference <= pairs[i - 1].reference + 2);
      }
      cost += Cost(observed, reference, i, pairs[i].reference);
    }
    CHECK(cost == Approx(min_cost).epsilon(1e-4));
  }
}

TEST_CASE("AlignFrames: a motion is aligned with itself frame by frame", "[core][model]") {
  const core::FrameMatrix motion = WanderingStates(40, 6, 3);
  const auto pairs = core::AlignFrames(motion, motion);
  for (int i = 0; i < 40; ++i) CHECK(pairs[i] == IndexPair{i, i});
}

TEST_CASE("UnitPairs: pairs units of one label, each with at most eight references",
          "[core][model]") {
  CHECK(core::UnitPairs(UnitsOf({"a", "b", "c"})).empty());
  CHECK(core::UnitPairs(UnitsOf({"", "", "c"})).empty());
  CHECK(core::UnitPairs(UnitsOf({"a", "b", "a"})) == std::vector<IndexPair>{{0, 2}, {2, 0}});

  std::vector<std::string> labels(1000, "many");
  labels[3] = labels[500] = "two";
  labels[7] = "one";
  const auto pairs = core::UnitPairs(UnitsOf(labels));
  std::set<int> observed;
  std::set<std::pair<int, int>> different;
  for (const IndexPair& pair : pairs) {
    CHECK(labels[pair.observed] == labels[pair.reference]);
    CHECK(pair.observed != pair.reference);
    observed.insert(pair.observed);
    different.insert({pair.observed, pair.reference});
  }
  CHECK(observed.size() == 256);
  CHECK(different.size() == pairs.size());
  CHECK(pairs.size() <= 8 * 256);
}

}  // namespace motiondb::tests::label_units_test
