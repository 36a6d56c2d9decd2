#include <algorithm>
#include <catch2/catch.hpp>

#include "core/planning/plan.h"
#include "core/planning/segment_graph.h"
#include "core/planning/synthesis.h"
#include "tests/core/planning/walking_database.h"
#include "tests/support/some_clips.h"

namespace motiondb::core::masked_plan_test {
namespace {

using tests::WalkingDatabase;

void CheckPlayed(const PlannedMotion& motion, const ClipMask& mask) {
  const Model& model = WalkingDatabase();
  for (const PlayedSegment& segment : motion.segments) {
    CHECK(mask.allows(model.clip_of_frame(segment.first_frame)));
    CHECK(mask.allows(model.clip_of_frame(segment.last_frame)));
  }
  for (const int node : motion.coarse_nodes) {
    CHECK(IsAllowedNode(model, motion.coarse_layer, node, &mask));
  }
  for (const int node : motion.bottom_nodes) {
    CHECK(IsAllowedNode(model, model.layer_count(), node, &mask));
  }
}

}  // namespace

TEST_CASE("Plan: with a mask only allowed clips are played", "[planning]") {
  const Model& model = WalkingDatabase();
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const auto mask = tests::SomeClips(model, 1 + static_cast<int>(seed) % 4, seed);
    PlanProblem problem;
    if (seed % 2 == 0) problem.start.clip = ClipMoment{"straight", 0.2};
    problem.goal = {1.0, 0.1, 0.1};
    problem.playable.mask = mask;
    problem.alternative_count = 1;
    problem.effort = 0.2;
    for (const PlanMethod method : {PlanMethod::kSegmentSearch, PlanMethod::kRandomSampling}) {
      problem.method = method;
      const auto answer = PlanMotion(model, tests::WalkerScheme(), problem);
      INFO(answer.status());
      REQUIRE(answer.ok());
      for (const PlannedMotion& motion : answer->motions) CheckPlayed(motion, *mask);
    }
  }
}

TEST_CASE("Plan: labels and mask restrict each other", "[planning]") {
  const Model& model = WalkingDatabase();
  std::vector<bool> allowed(model.clips().size());
  allowed[0] = allowed[2] = true;  // "straight" and a "bend"
  Playable playable{.labels = {"bend"}, .mask = tests::MaskOf(model, allowed)};
  const auto ranges = PlayableRanges(model, playable);
  REQUIRE(ranges.size() == 1);
  CHECK(ranges[0].clip == 2);
  const StoredFloor floor(model, 0.8);
  const SegmentGraph graph(model, floor, model.layer_count(), playable);
  for (const Run& run : graph.runs()) CHECK(model.clip_of_frame(run.first) == 2);
  const auto origins = FindOrigins(model, {}, playable);
  REQUIRE(origins.ok());
  for (const PlanOrigin& origin : *origins) CHECK(model.clip_of_frame(origin.frame) == 2);
  playable.labels = {"straight"};
  CHECK(PlayableGraph(model, 3, playable).edges() ==
        tests::MaskOf(model, {true, false, false, false, false, false, false, false})
            ->global_graph(3)
            .edges());
}

TEST_CASE("Plan: labels select the frames of their spans", "[planning]") {
  std::vector<ClipLabels> labels(WalkingDatabase().clips().size());
  labels[0].labels.Set("gait", {{"left", 0, 50}, {"right", 50, 60}, {"left", 110, 130}});
  labels[1].labels.Set("gait", {{"right", 20, 150}});
  const auto model = WalkingDatabase().WithLabels(labels);
  REQUIRE(model.ok());
  const Playable playable{.labels = {"left", "right"}, .track = "gait"};
  const auto both = PlayableRanges(*model, playable);
  REQUIRE(both.size() == 2);
  CHECK(both[0].first == 0);
  CHECK(both[0].end == 240);
  const auto right = PlayableRanges(*model, {.labels = {"right"}, .track = "gait"});
  REQUIRE(right.size() == 2);
  CHECK(right[0].first == 50);
  CHECK(right[0].end == 110);

  PlanProblem problem;
  problem.goal = {0.8, 0, 0};
  problem.playable = {.labels = {"right"}, .track = "gait"};
  const auto answer = PlanMotion(*model, tests::WalkerScheme(), problem);
  INFO(answer.status());
  REQUIRE(answer.ok());
  REQUIRE_FALSE(answer->motions.empty());
  for (const PlayedSegment& segment : answer->motions[0].segments) {
    CHECK(std::ranges::any_of(right, [&](const PlayableRange& range) {
      return segment.first_frame >= range.first && segment.last_frame < range.end;
    }));
  }
  problem.playable.track = "";
  CHECK(CheckProblem(*model, problem).code() == absl::StatusCode::kInvalidArgument);
}

TEST_CASE("Plan: a mask of all clips changes nothing", "[planning]") {
  const Model& model = WalkingDatabase();
  PlanProblem problem;
  problem.start.clip = ClipMoment{"straight", 0.2};
  problem.goal = {1.6, 0.5, 0.6};
  const auto all = PlanMotion(model, tests::WalkerScheme(), problem);
  problem.playable.mask = tests::SomeClips(model, static_cast<int>(model.clips().size()), 1);
  const auto masked = PlanMotion(model, tests::WalkerScheme(), problem);
  REQUIRE((all.ok() && masked.ok()));
  REQUIRE(all->motions.size() == masked->motions.size());
  CHECK(all->motions[0].markers.positions_m == masked->motions[0].markers.positions_m);
}

}  // namespace motiondb::core::masked_plan_test
