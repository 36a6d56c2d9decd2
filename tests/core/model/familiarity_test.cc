#include "core/model/familiarity.h"

#include <catch2/catch.hpp>

#include "core/model/model.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::familiarity_test {

TEST_CASE("Familiarity: scores equal those computed from all nodes of all layers",
          "[core][model]") {
  // With few markers, densities in many nodes are similar. 13 frames do not fill whole blocks.
  for (const int markers : {1, 3, 34}) {
    const core::Model model = SmallModel(3, 150, markers, 8, 5);
    std::vector<core::FrameRun> windows;
    for (int first = 0; first < 450; first += 60) windows.push_back({first, 13});
    const core::FamiliarityReference reference =
        core::MakeFamiliarityReference(windows, 13, model.states(), model.tree(), model.gaussians(),
                                       model.parts().global_graphs, core::RunSerially);
    REQUIRE(static_cast<int>(reference.scores.size()) == model.layer_count());
    for (int layer = 1; layer <= model.layer_count(); ++layer) {
      const int nodes = model.tree().node_count(layer);
      std::vector<double> expected;
      for (const core::FrameRun& window : windows) {
        core::EmissionMatrix densities(window.count, nodes);
        for (int t = 0; t < window.count; ++t) {
          for (int n = 0; n < nodes; ++n) {
            densities(t, n) = model.gaussians().LogDensity(
                model.tree().branch(layer, n), model.states().row(window.first + t).data());
          }
        }
        expected.push_back(core::FamiliarityScore(model.global_graph(layer), densities));
      }
      std::sort(expected.begin(), expected.end());
      CAPTURE(markers, layer);
      for (std::size_t w = 0; w < windows.size(); ++w) {
        CHECK(reference.scores[layer - 1][w] == Approx(expected[w]).epsilon(1e-5).margin(1e-4));
      }
    }
  }
}

TEST_CASE("Familiarity: independent of the execution order; a short clip is one window",
          "[core][model]") {
  const core::Model model = SmallModel(3, 80, 4, 8, 5);
  const core::ParallelFor backwards = [](int count, const std::function<void(int)>& body) {
    for (int i = count; i-- > 0;) body(i);
  };
  const std::vector<core::FrameRun> clips = {{0, 80}, {80, 5}, {85, 1}, {86, 154}};
  const auto make = [&](const core::ParallelFor& parallel) {
    return core::MakeFamiliarityReference(clips, 24, model.states(), model.tree(),
                                          model.gaussians(), model.parts().global_graphs, parallel);
  };
  const core::FamiliarityReference serial = make(core::RunSerially);
  CHECK(serial.scores == make(backwards).scores);
  CHECK(serial.scores.front().size() == 57 + 1 + 1 + 131);
}

}  // namespace motiondb::tests::familiarity_test
