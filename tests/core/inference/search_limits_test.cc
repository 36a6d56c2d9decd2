// Memory limits of the node path search, and its cancellation.
#include <catch2/catch.hpp>
#include <limits>

#include "core/inference/lattice.h"
#include "core/inference/node_path.h"
#include "core/inference/observation.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::search_limits_test {
namespace {

using Catch::Contains;

constexpr int kAny = std::numeric_limits<int>::max();

core::FrameMatrix Observation(const core::Model& model, int frames) {
  const auto clips = WanderingClips(1, frames, model.marker_set(), 9);
  auto scaled = core::ScaledObservation(model, clips.front().states);
  REQUIRE(scaled.ok());
  return *std::move(scaled);
}

// Nodes with transitions to themselves and to the next node.
core::TransitionGraph Ring(int nodes) {
  std::vector<std::int32_t> row_begin{0};
  std::vector<core::Edge> edges;
  for (int node = 0; node < nodes; ++node) {
    const int next = (node + 1) % nodes;
    edges.push_back({std::min(node, next), 3});
    edges.push_back({std::max(node, next), 1});
    row_begin.push_back(static_cast<std::int32_t>(edges.size()));
  }
  return {std::move(row_begin), std::move(edges)};
}

core::Lattice AllNodes(int frames, int nodes) {
  core::Lattice lattice(static_cast<std::size_t>(frames));
  for (int t = 0; t < frames; ++t) {
    core::LatticeFrame& frame = lattice[static_cast<std::size_t>(t)];
    frame.log_emission.resize(nodes);
    for (int node = 0; node < nodes; ++node) {
      frame.nodes.push_back(node);
      frame.log_emission[node] = -((node * 37 + t * 11) % 23);
    }
  }
  return lattice;
}

TEST_CASE("FindNodePaths: a beam as wide as the layer has the limit of the exact search",
          "[core][inference][hostile]") {
  const core::Model model = SmallModel(6, 400, 2, 2, 4);
  const int nodes = model.tree().node_count(model.layer_count());
  // Only the size of the states matters: the search is refused before candidates are allocated.
  const core::FrameMatrix observation =
      Observation(model, 2).colwise().mean().replicate((1 << 25) / nodes + 1, 1);
  for (const int candidates : {0, kAny}) {
    core::NodePathOptions options;
    options.max_candidates = candidates;
    const auto search = core::FindNodePaths(model, observation, options);
    REQUIRE(search.status().code() == absl::StatusCode::kInvalidArgument);
    CHECK_THAT(std::string(search.status().message()), Contains("max_candidates: "));
  }
}

TEST_CASE("FindNodePaths: many paths of many frames are refused", "[core][inference][hostile]") {
  const core::Model model = SmallModel(6, 400, 2, 2, 4);
  const core::FrameMatrix observation =
      Observation(model, 2).colwise().mean().replicate((1 << 26) / (100 * 32) + 1, 1);
  core::NodePathOptions options;
  options.path_count = 100;
  const auto search = core::FindNodePaths(model, observation, options);
  REQUIRE(search.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(search.status().message()), Contains("path_count: "));
}

TEST_CASE("FindNodePaths: a cancelled search ends", "[core][inference][hostile]") {
  const core::Model model = SmallModel(3, 60, 2, 4, 4);
  int checks = 0;
  const auto search =
      core::FindNodePaths(model, Observation(model, 50), {}, [&] { return ++checks > 1; });
  CHECK(search.status().code() == absl::StatusCode::kCancelled);
  CHECK(checks < 10);
}

TEST_CASE("Lattice: large frames end between two checks for cancellation",
          "[core][inference][hostile]") {
  constexpr int kNodes = 1500;
  const core::Lattice lattice = AllNodes(40, kNodes);
  const core::TransitionGraph graph = Ring(kNodes);
  int checks = 0;
  const core::Cancelled cancelled = [&] { return ++checks > 0; };
  CHECK(core::BestPaths(lattice, graph, 1e-6, 5, cancelled).empty());
  CHECK(checks == 1);
  core::MaxMarginals(lattice, graph, 1e-6, cancelled);
  CHECK(checks == 2);
  CHECK(core::LastNodeDistribution(lattice, graph, 1e-6, cancelled).sum() == 0);
  CHECK(checks == 3);
}

TEST_CASE("LastNodeDistribution: many candidates have the same probabilities as single ones",
          "[core][inference][hostile]") {
  constexpr int kNodes = 1100;  // squared, more than the size of the table
  const core::Lattice lattice = AllNodes(4, kNodes);
  const core::TransitionGraph graph = Ring(kNodes);
  for (const double floor : {0.0, 1e-6}) {
    Eigen::VectorXd forward = lattice[0].log_emission;
    for (std::size_t t = 1; t < lattice.size(); ++t) {
      Eigen::VectorXd next(kNodes);
      for (int to = 0; to < kNodes; ++to) {
        Eigen::VectorXd arriving(kNodes);
        for (int from = 0; from < kNodes; ++from) {
          const int count = graph.count(from, to);
          arriving[from] = forward[from] + (count > 0 ? std::log(count / 4.0) : std::log(floor));
        }
        next[to] = core::LogSum(arriving) + lattice[t].log_emission[to];
      }
      forward = next;
    }
    const Eigen::VectorXd expected = (forward.array() - core::LogSum(forward)).exp();
    const Eigen::VectorXd last = core::LastNodeDistribution(lattice, graph, floor);
    REQUIRE(last.size() == kNodes);
    CHECK((last - expected).cwiseAbs().maxCoeff() < 1e-12);
  }
}

}  // namespace
}  // namespace motiondb::tests::search_limits_test
