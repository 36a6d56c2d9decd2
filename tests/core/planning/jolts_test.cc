#include "core/planning/jolts.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/planning/segment_graph.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core {
namespace {

constexpr int kJolt = 200;

// Two walks; in the first, every marker is somewhere else for one frame.
Model JoltedDatabase() {
  std::vector<BuildInput> inputs;
  for (const char* id : {"jolted", "sound"}) {
    tests::WalkingFigure figure;
    figure.seconds = 6;
    MarkerMotion motion = figure.Motion();
    if (id == std::string("jolted")) {
      for (Eigen::Index c = 0; c < motion.positions_m.cols(); ++c) {
        motion.positions_m(kJolt, c) += c % 2 == 0 ? 0.05F : -0.05F;
      }
    }
    auto states = ComputeStates(tests::WalkerSet(), motion);
    REQUIRE(states.ok());
    inputs.push_back({id, "walk", *std::move(states)});
  }
  auto model = BuildModel({}, tests::WalkerSet(), std::move(inputs), Serially, {});
  REQUIRE(model.ok());
  return *std::move(model);
}

TEST_CASE("Jolts: found where the recording has them, and nowhere else", "[planning]") {
  const Model model = JoltedDatabase();
  Jolts jolts(model);
  for (int f = 0; f < model.frame_count(); ++f) {
    CHECK(jolts.At(f) == (std::abs(f - kJolt) <= 2 && f != kJolt + 2));
  }
  CHECK(jolts.Within(kJolt - 30, kJolt + 30));
  CHECK_FALSE(jolts.Within(kJolt + 10, kJolt + 30));
}

TEST_CASE("Jolts: a run that has one is known, and no join leads to it or fades over it",
          "[planning]") {
  const Model model = JoltedDatabase();
  const StoredFloor floor(model, tests::WalkingFigure::kLeg_m);
  SegmentGraph graph(model, floor, model.layer_count(), {});
  CHECK_FALSE(graph.Plays(graph.run_of_frame(kJolt)));
  Jolts jolts(model);
  int joins = 0;
  for (std::size_t run = 0; run < graph.runs().size(); ++run) {
    for (const RunJoin& join : graph.Joins(static_cast<int>(run))) {
      const auto& [leave, enter, window] = join.join;
      CHECK_FALSE(jolts.Within(leave - window, leave + window));
      CHECK_FALSE(jolts.Within(enter - window, enter + window));
      CHECK(graph.Plays(join.to));
      ++joins;
    }
  }
  CHECK(joins > 20);
}

}  // namespace
}  // namespace motiondb::core
