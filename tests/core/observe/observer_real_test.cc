// The observer on recorded motion that is not in the model.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/format/marker_set_file.h"
#include "core/observe/observer.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::observer_real_test {

TEST_CASE(
    "Observer: on real motion it equals Recognize of the window and approximates the exact filter",
    "[core][observe][data]") {
  MOTIONDB_REQUIRE_DATA();
  core::Model model = BuildFromList(DataDir() / "sets/database1.train.tsv", {.frame_rate_hz = 60});
  core::RecognitionCalibration recognition;
  for (int i = -200; i < 200; ++i) {
    recognition.window.familiarity.push_back(static_cast<float>(i) / 40);
  }
  model.set_recognition(recognition);
  const auto motion =
      core::ApplyScheme(core::StandardScheme(), LoadMotion(DataDir() / "cmu/07/07_06.amc").motion);
  REQUIRE(motion.ok());
  const auto resampled = core::Resample(*motion, 60);
  REQUIRE(resampled.ok());
  const core::MarkerSet& set = core::StandardScheme().set;
  const double leg_length_m = *core::EstimateLegLength(set, *resampled);
  auto observer =
      core::Observer::Create(model, core::StandardScheme(), set.markers, 60, leg_length_m, {});
  REQUIRE(observer.ok());
  for (Eigen::Index t = 0; t < resampled->positions_m.rows(); ++t) {
    REQUIRE((*observer)->Append(t, resampled->positions_m.row(t)).ok());
    if (t < 30 || t % 7 != 0) continue;
    const auto answer = (*observer)->Answer();
    REQUIRE((answer.ok() && answer->has_value()));
    core::MarkerMotion prefix = *resampled;
    prefix.positions_m.conservativeResize(t + 1, Eigen::NoChange);
    const auto states = core::ComputeStates(set, prefix, leg_length_m);
    REQUIRE(states.ok());
    core::StateSequence window = *states;
    window.states = states->states.bottomRows(24).eval();
    window.root_path = states->root_path.bottomRows(24).eval();
    const auto recognized = core::Recognize(model, window, {});
    REQUIRE(recognized.ok());
    CAPTURE(t);
    const auto& expected = recognized->front();
    for (std::size_t l = 0; l < expected.labels.size(); ++l) {
      CHECK((*answer)->labels[l].label == expected.labels[l].label);
      CHECK((*answer)->labels[l].probability ==
            Approx(expected.labels[l].probability).margin(1e-4));
    }
    CHECK((*answer)->familiarity == Approx(expected.familiarity).margin(0.006));
  }
}

}  // namespace motiondb::tests::observer_real_test
