#include "core/planning/random_sampling.h"

#include <catch2/catch.hpp>

#include "core/planning/goal.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::random_sampling_test {
namespace {

using tests::WalkingDatabase;

constexpr double kLeg = tests::WalkingFigure::kLeg_m;

TEST_CASE("Random sampling: follows stored transitions; the means determine its end",
          "[planning]") {
  const Model& model = WalkingDatabase();
  const int layer = model.layer_count() - 1;
  SearchSettings settings;
  settings.goal = {1, 0.1, 0.1};
  settings.seed = 4;
  const auto sampled = SampleWalks(model, layer, 10, {}, kLeg, {}, settings, {});
  REQUIRE(sampled.ok());
  REQUIRE(sampled->reached);
  const SampledPath& path = sampled->paths.front();
  const GoalError error = ErrorAt(path.coarse_end, settings.goal);
  CHECK(error.position_m <= settings.position_tolerance_m);
  CHECK(error.heading_rad <= settings.heading_tolerance_rad);
  CHECK(path.coarse_nodes.front() == model.tree().node_of_frame(layer, 10));
  for (std::size_t t = 1; t < path.coarse_nodes.size(); ++t) {
    CHECK(model.global_graph(layer).count(path.coarse_nodes[t - 1], path.coarse_nodes[t]) > 0);
  }
  CHECK(path.bottom_nodes.size() == path.coarse_nodes.size());
  CHECK(path.root.size() == path.coarse_nodes.size());

  const auto again = SampleWalks(model, layer, 10, {}, kLeg, {}, settings, {});
  CHECK(again->paths.front().coarse_nodes == path.coarse_nodes);
}

TEST_CASE("Random sampling: uses only allowed labels", "[planning]") {
  const Model& model = WalkingDatabase();
  const int layer = model.layer_count();
  SearchSettings settings;
  settings.goal = {2, 0, 0};
  settings.effort = 0.1;
  const auto sampled =
      SampleWalks(model, layer, 10, {.labels = {"straight"}}, kLeg, {}, settings, {});
  REQUIRE(sampled.ok());
  REQUIRE_FALSE(sampled->paths.empty());
  const std::vector<std::int32_t>& nodes = sampled->paths.front().coarse_nodes;
  for (std::size_t t = 1; t < nodes.size(); ++t) {
    bool seen = false;
    for (int f = 0; f + 1 < model.frame_count() && !seen; ++f) {
      seen = model.clip_of_frame(f) == model.clip_of_frame(f + 1) &&
             model.clips()[model.clip_of_frame(f)].label() == "straight" &&
             model.tree().node_of_frame(layer, f) == nodes[t - 1] &&
             model.tree().node_of_frame(layer, f + 1) == nodes[t];
    }
    CHECK(seen);
  }
}

TEST_CASE("Random sampling: ends even if no walk has time for a step", "[planning]") {
  SearchSettings settings;
  settings.goal = {1, 0, 0};
  settings.max_duration_seconds = 0.001;
  settings.effort = 0.01;
  const auto sampled = SampleWalks(WalkingDatabase(), 3, 10, {}, kLeg, {}, settings, {});
  REQUIRE(sampled.ok());
  CHECK_FALSE(sampled->reached);
}

TEST_CASE("Random sampling: can be cancelled", "[planning]") {
  SearchSettings settings;
  settings.goal = {-6, 5, 2};
  const auto cut = SampleWalks(WalkingDatabase(), 3, 10, {}, kLeg, {}, settings,
                               {.time_up = [] { return true; }});
  REQUIRE(cut.ok());
  CHECK(cut->time_up);
  CHECK(SampleWalks(WalkingDatabase(), 3, 10, {}, kLeg, {}, settings,
                    {.cancelled = [] { return true; }})
            .status()
            .code() == absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace motiondb::core::random_sampling_test
