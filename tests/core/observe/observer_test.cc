#include "core/observe/observer.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/states.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/shortlist.h"
#include "tests/core/observe/observing.h"

namespace motiondb::tests::observer_test {
namespace {

// Compares an answer with Recognize and Predict for the window that ends at `frame`.
void CheckAgainstQuestions(const core::Model& model, const core::MarkerMotion& motion, int frame,
                           const core::ObserverOptions& options, const core::Observed& answer) {
  core::MarkerMotion prefix = motion;
  prefix.positions_m.conservativeResize(frame + 1, Eigen::NoChange);
  const core::StateSequence known = PointStates(prefix);
  const int width = static_cast<int>(std::lround(options.window_seconds * 60));
  const auto windows = core::Recognize(model, core::PastAt(known, frame, width),
                                       {.window_seconds = options.window_seconds});
  REQUIRE(windows.ok());
  CAPTURE(frame);
  CheckLabels(answer.labels, windows->back().labels);
  CHECK(answer.familiarity == Approx(windows->back().familiarity).margin(0.003));
  if (options.horizon_seconds.empty()) return;
  core::PredictOptions predict;
  predict.history_seconds = options.history_seconds;
  predict.horizon_seconds = options.horizon_seconds;
  const auto prediction = core::Predict(model, known, predict);
  REQUIRE(prediction.ok());
  REQUIRE(answer.horizons.size() == prediction->horizons.size());
  for (std::size_t h = 0; h < answer.horizons.size(); ++h) {
    CHECK((answer.horizons[h].marker_positions_m - prediction->horizons[h].marker_positions_m)
              .norm() < 1e-3);
    CHECK(answer.horizons[h].expected_error_m.value_or(-1) ==
          Approx(prediction->horizons[h].expected_error_m.value_or(-1)).margin(1e-4));
  }
}

}  // namespace

TEST_CASE("Observer: equals Recognize and Predict of the window at every frame",
          "[core][observe]") {
  const core::MarkerMotion motion = Stream(150);
  for (const bool calibrated : {true, false}) {
    const core::Model model = PointModel(3, 3, calibrated);
    for (const double window_seconds : {0.4, 0.1, 1.2}) {
      core::ObserverOptions options;
      options.window_seconds = window_seconds;
      if (window_seconds == 0.4) options.horizon_seconds = {0.1, 0.5};
      const auto observer = Observe(model, options);
      for (int t = 0; t < 150; ++t) {
        Append(*observer, 1000 + t, motion.positions_m.row(t));
        // Requests an answer sometimes at each frame, sometimes at every few frames.
        if (t % 50 > 20 && t % 4 != 3) continue;
        const core::Observed answer = Answer(*observer);
        CHECK(answer.frame == 1000 + t);
        CHECK(answer.layer == model.layer_count());
        CheckAgainstQuestions(model, motion, t, options, answer);
      }
    }
  }
}

TEST_CASE("Observer: compares the same shortlist of clips as Recognize", "[core][observe]") {
  const core::Model model = PointModel(9, 9);
  const core::MarkerMotion motion = Stream(90);
  core::ObservedStates states(PointScheme().set, 60, 30);
  states.set_leg_length_m(kLegLength_m);
  core::WindowRecognizer recognizer(model, 24, 1e-6);
  int shortlists = 0;
  for (int t = 0; t < 90; ++t) {
    REQUIRE(states.Push(motion.positions_m.row(t)));
    const auto answer = recognizer.Recognize(states, {});
    REQUIRE(answer.ok());
    const int width = std::min(t + 1, 24);
    core::FrameMatrix scaled = states.Last(width).states;
    model.scale().Apply(scaled);
    const auto observed = core::MetricObservation::Create(model, scaled);
    REQUIRE(observed.ok());
    const core::FrameMatrix compared =
        observed->projected(core::ComparedFrames(0, width, 2, false), Eigen::all);
    CHECK(recognizer.shortlist().empty() == (observed->own != nullptr));
    if (observed->own == nullptr) {
      CHECK(recognizer.shortlist() == core::ShortlistClips(model, nullptr, compared));
      ++shortlists;
    }
    const auto windows = core::Recognize(model, states.Last(width), {});
    REQUIRE(windows.ok());
    CheckLabels(answer->labels, windows->front().labels);
    CHECK(answer->familiarity == Approx(windows->front().familiarity).margin(0.003));
  }
  CHECK(shortlists > 60);
}

TEST_CASE("Observer: a model without a metric uses the paper's method", "[core][observe]") {
  core::ModelParts parts = PointModel(2, 2).parts();
  parts.metric = {};
  const auto model = core::Model::Create(std::move(parts));
  REQUIRE(model.ok());
  const core::MarkerMotion motion = Stream(60);
  const auto observer = Observe(*model);
  Append(*observer, 0, motion.positions_m);
  CheckAgainstQuestions(*model, motion, 59, {}, Answer(*observer));
}

TEST_CASE("Observer: does not depend on the split of frames into messages", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(100);
  const auto at_once = Observe(model);
  Append(*at_once, 7, motion.positions_m);
  const auto one_by_one = Observe(model);
  for (int t = 0; t < 100; ++t) {
    Append(*one_by_one, 7 + t, motion.positions_m.row(t));
    Answer(*one_by_one);
  }
  CheckSame(Answer(*at_once), Answer(*one_by_one));
  CheckSame(Answer(*at_once), Answer(*at_once));  // an answer changes nothing
}

}  // namespace motiondb::tests::observer_test
