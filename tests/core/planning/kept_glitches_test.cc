#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/planning/segment_graph.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::kept_glitches_test {
namespace {

constexpr int kGlitch = 200;

// Two walks. The first keeps its glitches: every marker is far away in one frame.
Model GlitchedDatabase() {
  std::vector<BuildInput> inputs;
  for (const char* id : {"glitched", "sound"}) {
    tests::WalkingFigure figure;
    figure.seconds = 6;
    MarkerMotion motion = figure.Motion();
    if (id == std::string("glitched")) motion.positions_m.row(kGlitch).array() += 100;
    auto states =
        Represent({tests::WalkerSet(), {}}, motion, 60, GlitchPolicy::kKeep, std::nullopt, nullptr);
    INFO(states.status());
    REQUIRE(states.ok());
    inputs.push_back({id, "walk", *std::move(states)});
  }
  auto model = BuildModel({}, tests::WalkerSet(), std::move(inputs), RunSerially, {});
  REQUIRE(model.ok());
  return *std::move(model);
}

TEST_CASE("HasGlitch: exactly the frames affected by a kept glitch", "[planning]") {
  const Model model = GlitchedDatabase();
  for (int f = 0; f < model.frame_count(); ++f) {
    CHECK(model.HasGlitch(f, f) == (std::abs(f - kGlitch) <= 3));
  }
  CHECK(model.HasGlitch(kGlitch - 30, kGlitch + 30));
  CHECK_FALSE(model.HasGlitch(kGlitch + 10, kGlitch + 30));
}

TEST_CASE("SegmentGraph: no join leads to a run with a kept glitch or fades over it",
          "[planning]") {
  const Model model = GlitchedDatabase();
  const StoredFloor floor(model, tests::WalkingFigure::kLeg_m);
  SegmentGraph graph(model, floor, model.layer_count(), {});
  CHECK_FALSE(graph.IsFreeOfGlitches(graph.run_of_frame(kGlitch)));
  int joins = 0;
  for (std::size_t run = 0; run < graph.runs().size(); ++run) {
    for (const RunJoin& join : graph.Joins(static_cast<int>(run))) {
      const auto& [leave, enter, window] = join.join;
      CHECK_FALSE(model.HasGlitch(leave - window, leave + window));
      CHECK_FALSE(model.HasGlitch(enter - window, enter + window));
      CHECK(graph.IsFreeOfGlitches(join.to));
      ++joins;
    }
  }
  CHECK(joins > 20);
}

}  // namespace
}  // namespace motiondb::core::kept_glitches_test
