#include <catch2/catch.hpp>

#include "core/calibration/calibrate.h"
#include "core/motion/states.h"
#include "core/prediction/forecast.h"
#include "core/prediction/predict.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::prediction_trial_test {
namespace {

constexpr int kMarkers = 4;

void Backwards(int count, const std::function<void(int)>& body) {
  for (int i = count; i-- > 0;) body(i);
}

}  // namespace

TEST_CASE("FitPredictionConfidence: expected errors equal those of held-out motion",
          "[core][calibration]") {
  const core::Model model = SmallModel(6, 300, kMarkers, 8, 11);
  const auto fitted = core::FitPredictionConfidence(model, core::RunSerially, {});
  REQUIRE(fitted.ok());
  REQUIRE(fitted->models.size() == 6);

  const core::StateSequence unseen =
      WanderingClips(8, 300, model.marker_set(), 11)[7].states;  // not stored
  const core::FrameMatrix world = core::WorldPositions(unseen);
  double expected = 0;
  double measured = 0;
  core::Model calibrated = model;
  calibrated.set_confidence(*fitted);
  for (int frame = 40; frame < 220; frame += 9) {
    core::PredictOptions options;
    options.at_seconds = frame / 60.0;
    options.horizon_seconds = {0.4};
    const auto prediction = core::Predict(calibrated, unseen, options);
    REQUIRE(prediction.ok());
    expected += prediction->horizons[0].expected_error_m.value();
    for (int m = 0; m < kMarkers; ++m) {
      measured += (prediction->horizons[0].marker_positions_m.segment<3>(3 * m).transpose() -
                   world.row(frame + 24).segment<3>(3 * m))
                      .norm() /
                  kMarkers;
    }
  }
  CHECK(expected > 0.6 * measured);
  CHECK(expected < 1.7 * measured);
}

TEST_CASE("FitPredictionConfidence: supports motion at 1 Hz", "[core][calibration]") {
  for (const double rate : {1.0, 1.24}) {  // less than one frame of history
    core::BuildSettings settings;
    settings.min_frames = 4;
    settings.frame_rate_hz = rate;
    const core::MarkerSet set = SmallMarkerSet(kMarkers);
    const auto model = core::BuildModel(settings, set, WanderingClips(4, 30, set, 11, rate),
                                        core::RunSerially, {});
    REQUIRE(model.ok());
    CHECK(core::FitPredictionConfidence(*model, core::RunSerially, {}).ok());
  }
}

TEST_CASE(
    "FitPredictionConfidence: independent of the order of work; empty for one clip or short clips",
    "[core][calibration]") {
  const core::Model model = SmallModel(3, 200, kMarkers, 8, 11);
  const auto once = core::FitPredictionConfidence(model, core::RunSerially, {});
  const auto again = core::FitPredictionConfidence(model, Backwards, {});
  REQUIRE(once->models.size() == again->models.size());
  for (std::size_t h = 0; h < once->models.size(); ++h) {
    CHECK(once->models[h].coefficients == again->models[h].coefficients);
    CHECK(once->models[h].deviation == again->models[h].deviation);
  }
  const core::Model single = SmallModel(1, 200, kMarkers, 8, 11);
  CHECK(core::FitPredictionConfidence(single, core::RunSerially, {})->models.empty());
  const core::Model brief = SmallModel(4, 20, kMarkers, 8, 11);
  CHECK(core::FitPredictionConfidence(brief, core::RunSerially, {})->models.empty());
  CHECK(core::FitPredictionConfidence(model, core::RunSerially,
                                      [](double, std::string_view) { return false; })
            .status()
            .code() == absl::StatusCode::kCancelled);
}

}  // namespace motiondb::tests::prediction_trial_test
