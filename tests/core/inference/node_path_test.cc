#include "core/inference/node_path.h"

#include <catch2/catch.hpp>

#include "core/inference/estimate.h"
#include "core/inference/observation.h"
#include "tests/core/inference/exhaustive_paths.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests {
namespace {

// Every node of a layer for every frame, with eq. 8 over all of them.
core::Lattice FullLattice(const core::Model& model, int layer, const core::FrameMatrix& scaled) {
  core::Lattice lattice;
  for (Eigen::Index t = 0; t < scaled.rows(); ++t) {
    core::LatticeFrame& frame = lattice.emplace_back();
    const int nodes = model.tree().node_count(layer);
    frame.log_emission.resize(nodes);
    for (int node = 0; node < nodes; ++node) {
      frame.nodes.push_back(node);
      frame.log_emission[node] =
          model.gaussians().LogDensity(model.tree().branch(layer, node), scaled.row(t).data());
    }
    core::NormalizeEmission(frame.log_emission);
  }
  return lattice;
}

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

TEST_CASE("FindNodePaths: the strict rule finds a clip's own path, and says where there is none",
          "[core][inference]") {
  const core::Model model = SmallModel(2, 200, 2, 4, 8);
  const auto clip = WanderingClips(2, 200, model.marker_set(), 8)[1].states;
  const auto own = core::FindNodePaths(model, Scaled(model, clip), {0, 1, 0, 0});
  REQUIRE(own.ok());
  for (std::size_t t = 1; t < own->paths[0].nodes.size(); ++t) {
    CHECK(model.global_graph(own->layer).count(own->paths[0].nodes[t - 1], own->paths[0].nodes[t]) >
          0);
  }
  // Pruned to almost nothing, the search must still find what the strict rule allows.
  const auto pruned = core::FindNodePaths(model, Scaled(model, clip), {0, 1, 0, 1});
  CHECK(pruned.ok());
}

TEST_CASE("FindNodePaths: bad options are refused by name", "[core][inference]") {
  const core::Model model = SmallModel(2, 60, 2, 10, 1);
  const auto clip = WanderingClips(1, 10, model.marker_set(), 1)[0].states;
  const auto message = [&](const core::NodePathOptions& options) {
    const auto result = core::Estimate(model, clip, {.search = options});
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
  CHECK(core::Estimate(model, clip, {}, [] { return true; }).status().code() ==
        absl::StatusCode::kCancelled);
}

TEST_CASE("Estimate: the state is the last node of the best path, with its posterior",
          "[core][inference]") {
  const core::Model model = SmallModel(4, 150, 3, 6, 21);
  const auto clip = WanderingClips(4, 150, model.marker_set(), 21)[2].states;
  const auto estimation = core::Estimate(model, clip, {.search = {0, 5, 1e-6, 0}});
  REQUIRE(estimation.ok());
  CHECK(estimation->layer == model.layer_count());
  REQUIRE(estimation->paths.size() == 5);
  CHECK(estimation->paths[0].nodes.size() == 150);
  CHECK(estimation->state.node == estimation->paths[0].nodes.back());
  const auto last =
      core::LastNodeDistribution(FullLattice(model, model.layer_count(), Scaled(model, clip)),
                                 model.global_graph(model.layer_count()), 1e-6);
  CHECK(estimation->state.probability == Approx(last[estimation->state.node]));
  // The clip was stored: near the root, where nodes are far apart, its frames lie where the tree
  // has them.
  const auto coarse = core::Estimate(model, clip, {.search = {3, 1, 1e-6, 0}});
  REQUIRE(coarse.ok());
  int same = 0;
  for (int t = 0; t < 150; ++t) {
    same += coarse->paths[0].nodes[t] == model.tree().node_of_frame(3, 300 + t);
  }
  CHECK(same > 110);
}

}  // namespace motiondb::tests
