#include <catch2/catch.hpp>
#include <cmath>

#include "core/inference/node_path.h"
#include "core/observe/observer.h"
#include "tests/core/observe/observing.h"
#include "tests/support/some_clips.h"

namespace motiondb::tests::masked_observer_test {
namespace {

void CheckAgainstMaskedQueries(const core::Model& model, const core::MarkerMotion& motion,
                               int frame, const core::ObserverOptions& options,
                               const std::shared_ptr<const core::ClipMask>& mask,
                               const core::Observed& answer) {
  CAPTURE(frame);
  core::MarkerMotion prefix = motion;
  prefix.positions_m.conservativeResize(frame + 1, Eigen::NoChange);
  const core::StateSequence known = PointStates(prefix);
  core::RecognizeOptions recognize;
  recognize.mask = mask;
  const auto windows = core::Recognize(model, core::PastAt(known, frame, 24), recognize);
  REQUIRE(windows.ok());
  CheckLabels(answer.labels, windows->back().labels);
  CHECK(answer.familiarity == Approx(windows->back().familiarity).margin(0.003));
  CHECK(core::IsAllowedNode(model, answer.layer, answer.state.node, mask.get()));
  core::PredictOptions predict;
  predict.horizon_seconds = options.horizon_seconds;
  predict.mask = mask;
  const auto prediction = core::Predict(model, known, predict);
  REQUIRE(prediction.ok());
  REQUIRE(answer.horizons.size() == prediction->horizons.size());
  for (std::size_t h = 0; h < answer.horizons.size(); ++h) {
    CHECK((answer.horizons[h].marker_positions_m - prediction->horizons[h].marker_positions_m)
              .norm() < 1e-3);
  }
}

}  // namespace

TEST_CASE("Observer: with a mask equals masked Recognize and Predict at every frame",
          "[core][observe]") {
  const core::MarkerMotion motion = Stream(110);
  for (const bool calibrated : {true, false}) {
    const core::Model model = PointModel(4, 3, calibrated);
    for (unsigned seed = 1; seed <= 3; ++seed) {
      core::ObserverOptions options;
      options.horizon_seconds = {0.1, 0.5};
      options.mask = SomeClips(model, 2 * static_cast<int>(seed), seed);
      const auto observer = Observe(model, options);
      for (int t = 0; t < 110; ++t) {
        Append(*observer, t, motion.positions_m.row(t));
        if (t % 5 != 4) continue;
        CheckAgainstMaskedQueries(model, motion, t, options, options.mask, Answer(*observer));
      }
    }
  }
}

TEST_CASE("Observer: with a mask and many clips equals masked Recognize", "[core][observe]") {
  const core::MarkerMotion motion = Stream(60);
  const core::Model model = PointModel(10, 10);
  core::ObserverOptions options;
  options.mask = SomeClips(model, 75, 3);  // a shortlist has 64
  const auto observer = Observe(model, options);
  for (int t = 0; t < 60; ++t) {
    Append(*observer, t, motion.positions_m.row(t));
    if (t % 5 != 4) continue;
    core::MarkerMotion prefix = motion;
    prefix.positions_m.conservativeResize(t + 1, Eigen::NoChange);
    core::RecognizeOptions recognize;
    recognize.mask = options.mask;
    const auto windows =
        core::Recognize(model, core::PastAt(PointStates(prefix), t, 24), recognize);
    REQUIRE(windows.ok());
    CheckLabels(Answer(*observer).labels, windows->back().labels);
  }
}

TEST_CASE("Observer: a new model has its own mask", "[core][observe]") {
  const core::MarkerMotion motion = Stream(60);
  const core::Model first = PointModel(2, 2);
  const core::Model second = PointModel(3, 3);
  core::ObserverOptions options;
  options.mask = SomeClips(first, 1, 1);
  const auto observer = Observe(first, options);
  Append(*observer, 0, motion.positions_m);
  const auto mask = SomeClips(second, 4, 2);
  REQUIRE(observer->Replace(second, mask).ok());
  CheckAgainstMaskedQueries(second, motion, 59, {}, mask, Answer(*observer));
  REQUIRE(observer->Replace(second).ok());
  CheckAgainstMaskedQueries(second, motion, 59, {}, nullptr, Answer(*observer));
}

TEST_CASE("NodeFilter: with a mask and no beam equals the masked paths", "[core][observe]") {
  const core::Model model = PointModel(3, 3);
  const core::FrameMatrix states = [&] {
    core::FrameMatrix scaled = PointStates(PointMotion(40, 1, 77)).states;
    model.scale().Apply(scaled);
    return scaled;
  }();
  const auto mask = SomeClips(model, 3, 4);
  core::NodeFilter filter(model, model.layer_count(), 1e-6, mask.get(), 0);
  for (Eigen::Index t = 0; t < states.rows(); ++t) filter.Advance(states.row(t).data());
  core::NodePathOptions options{.max_candidates = 0, .mask = mask};
  const auto search = core::FindNodePaths(model, states, options);
  REQUIRE(search.ok());
  const auto last = core::LastNodes(model, *search, 1e-6);
  REQUIRE(last.ok());
  for (const core::NodeState& state : *last) {
    const auto at = std::ranges::find(filter.nodes(), state.node);
    REQUIRE(at != filter.nodes().end());
    CHECK(filter.probability()[at - filter.nodes().begin()] ==
          Approx(state.probability).margin(1e-9));
  }
}

}  // namespace motiondb::tests::masked_observer_test
