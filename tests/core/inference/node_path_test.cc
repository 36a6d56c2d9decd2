#include "core/inference/node_path.h"

#include <catch2/catch.hpp>

#include "core/inference/observation.h"
#include "tests/core/inference/exhaustive_paths.h"
#include "tests/core/inference/full_lattice.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::node_path_test {
namespace {

core::FrameMatrix Scaled(const core::Model& model, const core::StateSequence& observation) {
  auto scaled = core::ScaledObservation(model, observation);
  REQUIRE(scaled.ok());
  return *std::move(scaled);
}

core::StateSequence NewClip(const core::Model& model, int frames, unsigned seed) {
  return WanderingClips(1, frames, model.marker_set(), seed).front().states;
}

}  // namespace

TEST_CASE("FindNodePaths: with pruning off equals exhaustive search on a small tree",
          "[core][inference]") {
  const core::Model model = SmallModel(3, 60, 2, 20, 4);
  REQUIRE(model.tree().node_count(model.layer_count()) <= 8);
  const core::FrameMatrix scaled = Scaled(model, NewClip(model, 5, 4));
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    for (const double floor : {1e-6, 0.1}) {
      const auto all =
          AllPaths(FullLattice(model, layer, scaled), model.global_graph(layer), floor);
      core::NodePathOptions options{layer, 7, floor, 0};
      const auto search = core::FindNodePaths(model, scaled, options);
      REQUIRE(search.ok());
      REQUIRE(search->paths.size() == std::min<std::size_t>(7, all.size()));
      for (std::size_t i = 0; i < search->paths.size(); ++i) {
        CHECK(search->paths[i].log_probability == Approx(all[i].log_probability).margin(1e-6));
      }
      CHECK(search->paths[0].nodes == all[0].nodes);
    }
  }
}

TEST_CASE("FindNodePaths: with pruning off equals exact Viterbi on every layer of a real tree",
          "[core][inference][data]") {
  MOTIONDB_REQUIRE_DATA();
  const core::Model model = BuildFromList(DataDir() / "sets" / "database1.train.tsv", {});
  const core::FrameMatrix scaled =
      Scaled(model, LoadStates(DataDir() / "cmu/02/02_03.amc", model.settings().frame_rate_hz));
  int beam_equals = 0;
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    const core::NodePath exact =
        Viterbi(FullLattice(model, layer, scaled), model.global_graph(layer), 1e-6);
    const auto unpruned = core::FindNodePaths(model, scaled, {layer, 1, 1e-6, 0});
    REQUIRE(unpruned.ok());
    CHECK(unpruned->paths[0].nodes == exact.nodes);
    CHECK(unpruned->paths[0].log_probability == Approx(exact.log_probability).epsilon(1e-6));
    const auto beam = core::FindNodePaths(model, scaled, {layer, 1, 1e-6, 16});
    REQUIRE(beam.ok());
    beam_equals += beam->paths[0].nodes == exact.nodes;
  }
  std::printf("Node paths kept to 16 candidates equal exact Viterbi on %d of %d layers\n",
              beam_equals, model.layer_count());
  CHECK(beam_equals >= model.layer_count() - 2);
}

TEST_CASE("FindNodePaths: the strict rule finds a clip's own path, or reports that there is none",
          "[core][inference]") {
  const core::Model model = SmallModel(2, 200, 2, 4, 8);
  const auto clip = WanderingClips(2, 200, model.marker_set(), 8)[1].states;
  const auto own = core::FindNodePaths(model, Scaled(model, clip), {0, 1, 0, 0});
  REQUIRE(own.ok());
  for (std::size_t t = 1; t < own->paths[0].nodes.size(); ++t) {
    CHECK(model.global_graph(own->layer).count(own->paths[0].nodes[t - 1], own->paths[0].nodes[t]) >
          0);
  }
  // Even with extreme pruning, the search must find the path that the strict rule allows.
  const auto pruned = core::FindNodePaths(model, Scaled(model, clip), {0, 1, 0, 1});
  CHECK(pruned.ok());
}

TEST_CASE("FindNodePaths: bad options are refused by name", "[core][inference]") {
  const core::Model model = SmallModel(2, 60, 2, 10, 1);
  const auto clip = WanderingClips(1, 10, model.marker_set(), 1)[0].states;
  const auto message = [&](const core::NodePathOptions& options) {
    const auto result = core::FindNodePaths(model, Scaled(model, clip), options);
    CHECK_FALSE(result.ok());
    return std::string(result.status().message());
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(message({0, 0, 1e-6, 16}), Contains("path_count"));
  CHECK_THAT(message({0, 101, 1e-6, 16}), Contains("path_count"));
  CHECK_THAT(message({0, 1, -1, 16}), Contains("transition_floor"));
  CHECK_THAT(message({0, 1, std::nan(""), 16}), Contains("transition_floor"));
  CHECK_THAT(message({0, 1, 1e-6, -1}), Contains("max_candidates"));
  CHECK_THAT(message({99, 1, 1e-6, 16}), Contains("layer"));
  CHECK(core::FindNodePaths(model, Scaled(model, clip), {}, [] { return true; }).status().code() ==
        absl::StatusCode::kCancelled);
}

}  // namespace motiondb::tests::node_path_test
