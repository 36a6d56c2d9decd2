// Estimation in some clips, compared with exhaustive computations over these clips alone.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/estimation/estimate.h"
#include "core/inference/observation.h"
#include "core/model/clip_graphs.h"
#include "tests/core/inference/exhaustive_paths.h"
#include "tests/support/some_clips.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::masked_estimate_test {
namespace {

// All nodes with frames of the allowed clips.
core::Lattice AllowedLattice(const core::Model& model, int layer, const core::ClipMask& mask,
                             const core::FrameMatrix& scaled) {
  std::set<int> nodes;
  for (int frame = 0; frame < model.frame_count(); ++frame) {
    if (!mask.allows(model.clip_of_frame(frame))) continue;
    nodes.insert(model.tree().node_of_frame(layer, frame));
  }
  core::Lattice lattice;
  for (Eigen::Index t = 0; t < scaled.rows(); ++t) {
    core::LatticeFrame& frame = lattice.emplace_back();
    frame.nodes.assign(nodes.begin(), nodes.end());
    frame.log_emission.resize(std::ssize(nodes));
    for (std::size_t i = 0; i < frame.nodes.size(); ++i) {
      frame.log_emission[static_cast<Eigen::Index>(i)] = model.gaussians().LogDensity(
          model.tree().branch(layer, frame.nodes[i]), scaled.row(t).data());
    }
    core::NormalizeEmission(frame.log_emission);
  }
  return lattice;
}

core::TransitionGraph AllowedCounts(const core::Model& model, int layer,
                                    const core::ClipMask& mask) {
  std::vector<core::ModelClip> clips;
  for (const int clip : mask.clips()) clips.push_back(model.clips()[clip]);
  return core::CountGlobalGraph(model.tree(), layer, clips);
}

}  // namespace

TEST_CASE("Estimate: with a mask equals exact Viterbi over the allowed clips' counts",
          "[core][estimation]") {
  const core::Model model = SmallModel(8, 100, 3, 6, 21);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto mask = SomeClips(model, 1 + static_cast<int>(seed) % 4, seed);
    const auto clip = WanderingClips(8, 60, model.marker_set(), 21 + seed % 3)[seed % 8].states;
    for (const int layer : {3, model.layer_count()}) {
      core::EstimateOptions options;
      options.search = {layer, 1, 1e-6, 0, mask};
      const auto estimation = core::Estimate(model, clip, options);
      INFO(estimation.status());
      REQUIRE(estimation.ok());
      const auto lattice =
          AllowedLattice(model, layer, *mask, *core::ScaledObservation(model, clip));
      const auto graph = AllowedCounts(model, layer, *mask);
      const core::NodePath best = Viterbi(lattice, graph, 1e-6);
      CHECK(estimation->paths.front().log_probability == Approx(best.log_probability));
      CHECK(estimation->paths.front().nodes == best.nodes);
      const auto last = core::LastNodeDistribution(lattice, graph, 1e-6);
      const auto at = std::ranges::find(lattice.back().nodes, estimation->state.node);
      REQUIRE(at != lattice.back().nodes.end());
      CHECK(estimation->state.probability == Approx(last[at - lattice.back().nodes.begin()]));
    }
  }
}

TEST_CASE("Estimate: with a mask the beam keeps only nodes of the allowed clips",
          "[core][estimation]") {
  const core::Model model = SmallModel(8, 150, 3, 6, 21);
  const auto mask = SomeClips(model, 2, 5);
  const auto clip = WanderingClips(8, 100, model.marker_set(), 21)[3].states;
  core::EstimateOptions options;
  options.search.mask = mask;
  options.search.max_candidates = 4;
  options.search.path_count = 3;
  const auto estimation = core::Estimate(model, clip, options);
  REQUIRE(estimation.ok());
  for (const core::NodePath& path : estimation->paths) {
    for (const int node : path.nodes) {
      CHECK(core::IsAllowedNode(model, estimation->layer, node, mask.get()));
    }
  }
}

TEST_CASE("Estimate: missing markers are filled from the allowed clips", "[core][estimation]") {
  const core::Model model = SmallModel(4, 150, 4, 6, 21);
  auto clip = WanderingClips(4, 30, model.marker_set(), 21)[2].states;
  clip.states.row(29).segment<6>(18).setConstant(std::nanf(""));
  const auto mask = MaskOf(model, {false, true, false, false});
  const auto pool = core::ExemplarPool(model, model.layer_count(), {{0, 1.0}}, mask.get());
  const core::FrameMatrix scaled = *core::ScaledObservation(model, clip);
  const auto frames = core::NearestFrames(model, pool, scaled.row(29).data(), 64, mask.get());
  CHECK(frames.size() == 64);
  for (const core::Exemplar& exemplar : frames) CHECK(model.clip_of_frame(exemplar.frame) == 1);
  core::EstimateOptions options;
  options.search.mask = mask;
  const auto estimation = core::Estimate(model, clip, options);
  REQUIRE(estimation.ok());
  REQUIRE(estimation->filled.size() == 1);
  CHECK(estimation->filled.front().marker_positions_m.allFinite());
}

}  // namespace motiondb::tests::masked_estimate_test
