#include "core/model/label_units.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/model/label_tracks.h"
#include "core/model/model.h"

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

}  // namespace motiondb::tests::label_units_test
