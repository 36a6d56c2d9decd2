#include "core/estimation/estimate.h"

#include <catch2/catch.hpp>

#include "core/inference/observation.h"
#include "tests/core/inference/full_lattice.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::estimate_test {

TEST_CASE("Estimate: the state is the last node of the best path, with its posterior",
          "[core][estimation]") {
  const core::Model model = SmallModel(4, 150, 3, 6, 21);
  const auto clip = WanderingClips(4, 150, model.marker_set(), 21)[2].states;
  const auto estimation = core::Estimate(model, clip, {.search = {0, 5, 1e-6, 0}});
  REQUIRE(estimation.ok());
  CHECK(estimation->layer == model.layer_count());
  REQUIRE(estimation->paths.size() == 5);
  CHECK(estimation->paths[0].nodes.size() == 150);
  CHECK(estimation->state.node == estimation->paths[0].nodes.back());
  const auto last = core::LastNodeDistribution(
      FullLattice(model, model.layer_count(), *core::ScaledObservation(model, clip)),
      model.global_graph(model.layer_count()), 1e-6);
  CHECK(estimation->state.probability == Approx(last[estimation->state.node]));
  // The clip is stored: near the root, where nodes are far apart, its frames get their nodes of the
  // tree.
  const auto coarse = core::Estimate(model, clip, {.search = {3, 1, 1e-6, 0}});
  REQUIRE(coarse.ok());
  int same = 0;
  for (int t = 0; t < 150; ++t) {
    same += coarse->paths[0].nodes[t] == model.tree().node_of_frame(3, 300 + t);
  }
  CHECK(same > 110);
}

}  // namespace motiondb::tests::estimate_test
