#include "core/observe/node_filter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests::node_filter_test {
namespace {

// A motion similar to the model's, with some markers missing.
core::FrameMatrix Observation(const core::Model& model, int frames) {
  core::MarkerMotion motion = PointMotion(frames, 1, 77);
  Hide(motion, 3, 10, 14);
  for (int m = 0; m < 6; ++m) Hide(motion, m, 30, 32);
  const auto scaled = core::ScaledObservation(model, PointStates(motion));
  REQUIRE(scaled.ok());
  return *scaled;
}

std::vector<core::NodeState> Exact(const core::Model& model, const core::FrameMatrix& observation,
                                   int layer, double floor) {
  const auto search = core::FindNodePaths(
      model, observation, {.layer = layer, .transition_floor = floor, .max_candidates = 0});
  INFO(search.status());
  REQUIRE(search.ok());
  return *core::LastNodes(model, *search, floor);
}

double ProbabilityOf(const core::NodeFilter& filter, int node) {
  const auto at = std::ranges::find(filter.nodes(), node);
  return at == filter.nodes().end()
             ? 0
             : filter.probability()[static_cast<std::size_t>(at - filter.nodes().begin())];
}

double Sum(const core::NodeFilter& filter) {
  return std::accumulate(filter.probability().begin(), filter.probability().end(), 0.0);
}

}  // namespace

TEST_CASE("NodeFilter: with all nodes it equals LastNodeDistribution, on every layer",
          "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::FrameMatrix observation = Observation(model, 60);
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    for (const double floor : {1e-6, 0.01}) {
      core::NodeFilter filter(model, layer, floor, nullptr, 0);
      for (Eigen::Index t = 0; t < observation.rows(); ++t) {
        const core::NodeState ahead = filter.Peek(observation.row(t).data());
        filter.Advance(observation.row(t).data());
        CHECK(ProbabilityOf(filter, ahead.node) == ahead.probability);
        CHECK(*std::ranges::max_element(filter.probability()) == ahead.probability);
        if (t % 9 != 0) continue;
        for (const core::NodeState& state :
             Exact(model, observation.topRows(t + 1), layer, floor)) {
          CAPTURE(layer, floor, t, state.node);
          REQUIRE(ProbabilityOf(filter, state.node) == Approx(state.probability).margin(1e-9));
        }
      }
    }
  }
}

TEST_CASE("NodeFilter: the beam approximates the result with all nodes", "[core][observe]") {
  const core::Model model = PointModel(3, 3);
  const core::FrameMatrix observation = Observation(model, 120);
  core::NodeFilter beam(model, model.layer_count(), 1e-6);
  core::NodeFilter all(model, model.layer_count(), 1e-6, nullptr, 0);
  double apart = 0;
  for (Eigen::Index t = 0; t < observation.rows(); ++t) {
    beam.Advance(observation.row(t).data());
    all.Advance(observation.row(t).data());
    CHECK(beam.nodes().size() <= 32);
    CHECK(Sum(beam) == Approx(1));
    if (t >= 30 && t <= 33) continue;  // all markers are missing
    for (std::size_t i = 0; i < all.nodes().size(); ++i) {
      apart += std::abs(all.probability()[i] - ProbabilityOf(beam, all.nodes()[i])) / 2;
    }
  }
  CHECK(apart / 116 < 0.01);
}

TEST_CASE("NodeFilter: the strict rule restarts if no transition is allowed", "[core][observe]") {
  const core::Model model = PointModel(2, 1);
  const int layer = model.layer_count();
  const core::NodeGaussians& gaussians = model.gaussians();
  core::NodeFilter filter(model, layer, 0);
  // Two nodes without a path between them in the graph.
  int from = 0;
  int to = 0;
  for (int node = 0; node < model.tree().node_count(layer); ++node) {
    if (model.global_graph(layer).count(from, node) == 0) to = node;
  }
  REQUIRE(to != from);
  const auto state = [&](int node) {
    return gaussians.means().row(model.tree().branch(layer, node)).data();
  };
  filter.Advance(state(from));
  CHECK(filter.Peek(state(to)).probability > 0);
  for (int i = 0; i < 5; ++i) filter.Advance(state(to));
  CHECK(Sum(filter) == Approx(1));
  // So far away that every density is 0.
  const Eigen::RowVectorXf far = Eigen::RowVectorXf::Constant(model.states().cols(), 1e30F);
  filter.Advance(far.data());
  CHECK(Sum(filter) == Approx(1));
}

}  // namespace motiondb::tests::node_filter_test
