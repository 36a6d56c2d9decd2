#include "core/planning/extrapolation.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/model/model.h"
#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::extrapolation_test {
namespace {

core::PlannedMotion Played(const core::StateSequence& states, const core::MarkerSet& set) {
  core::PlannedMotion motion;
  motion.markers = {set.markers, states.frame_rate_hz, core::WorldPositions(states)};
  return motion;
}

TEST_CASE("MeasureExtrapolation: the window that is least like stored motion", "[core][planning]") {
  const core::MarkerSet set = SmallMarkerSet(2);
  const core::StateSequence states = WanderingClips(4, 120, set, 1)[0].states;
  core::Model model = SmallModel(4, 120, 2, 8, 1);
  core::PlannedMotion motion = Played(states, set);
  const auto measure = [&] {
    return core::MeasureExtrapolation(model, set, nullptr, states.leg_length_m, {}, motion);
  };
  REQUIRE(measure().ok());
  CHECK_FALSE(motion.quality.unknown.has_value());  // not calibrated

  core::RecognitionCalibration calibration;
  calibration.window.unknown = core::UnknownModel{.intercept = 1, .weights = {0.5, -0.5}};
  calibration.unknown = core::UnknownCalibration::kFitted;
  model.set_recognition(calibration);
  REQUIRE(measure().ok());
  const auto again = core::ComputeStates(set, motion.markers, states.leg_length_m);
  REQUIRE(again.ok());
  const auto windows = core::Recognize(model, *again, {});
  REQUIRE(windows.ok());
  const auto least =
      std::ranges::max_element(*windows, {}, &core::RecognizedWindow::unknown_probability);
  REQUIRE(motion.quality.unknown.has_value());
  CHECK(motion.quality.unknown->probability == least->unknown_probability);
  CHECK(motion.quality.unknown->seconds == (least->start_seconds + least->end_seconds) / 2);

  core::PlannedMotion one_frame = motion;
  one_frame.quality.unknown.reset();
  one_frame.markers.positions_m.conservativeResize(1, Eigen::NoChange);
  REQUIRE(core::MeasureExtrapolation(model, set, nullptr, 1, {}, one_frame).ok());
  CHECK_FALSE(one_frame.quality.unknown.has_value());
}

}  // namespace
}  // namespace motiondb::tests::extrapolation_test
