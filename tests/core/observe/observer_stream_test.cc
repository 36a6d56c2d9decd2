// Realistic streams: late frames, gaps, unknown body size, another frame rate.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "core/observe/observer.h"
#include "tests/core/observe/observing.h"

namespace motiondb::tests::observer_stream_test {
namespace {

constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();

}  // namespace

TEST_CASE("Observer: late frames are ignored, skipped numbers are missing frames",
          "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(100);
  const auto observer = Observe(model);
  Append(*observer, 0, motion.positions_m.topRows(40));
  Append(*observer, 30, motion.positions_m.middleRows(30, 15));  // ten of them are late
  CHECK(observer->late_frames() == 10);
  Append(*observer, 3, motion.positions_m.topRows(2));
  CHECK(observer->late_frames() == 12);
  Append(*observer, 50, motion.positions_m.middleRows(50, 50));
  CHECK(observer->missing_frames() == 5);

  core::MarkerMotion with_gap = motion;
  for (int m = 0; m < 6; ++m) Hide(with_gap, m, 45, 50);
  const auto expected = Observe(model);
  Append(*expected, 0, with_gap.positions_m);
  CHECK(expected->missing_frames() == 0);
  CheckSame(Answer(*observer), Answer(*expected));
}

TEST_CASE("Observer: a gap longer than the window restarts it", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(100);
  const auto fresh = Observe(model);
  Append(*fresh, 0, motion.positions_m.bottomRows(30));
  for (const std::int64_t gap : {std::int64_t{25}, std::int64_t{1} << 62, kMost - 200}) {
    const auto observer = Observe(model);
    Append(*observer, 0, motion.positions_m.topRows(70));
    Append(*observer, 70 + gap, motion.positions_m.bottomRows(30));
    CHECK(observer->missing_frames() == gap);
    CHECK(observer->kept_frames() == 30);
    CheckSame(Answer(*observer), Answer(*fresh));
  }
  const auto observer = Observe(model);
  Append(*observer, kLeast, motion.positions_m.topRows(70));
  Append(*observer, kMost - 29, motion.positions_m.bottomRows(30));
  CHECK(observer->missing_frames() == kMost);
  CheckSame(Answer(*observer), Answer(*fresh));
  Append(*observer, kMost, motion.positions_m.row(0));
  CHECK(observer->late_frames() == 1);
}

TEST_CASE("Observer: has no answer before it has seen both hips", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  core::MarkerMotion motion = Stream(100);
  Hide(motion, 0, 0, 10);
  for (const bool is_told : {true, false}) {
    const auto observer = Observe(model, {}, is_told ? std::optional(kLegLength_m) : std::nullopt);
    CHECK_FALSE(observer->Answer()->has_value());
    for (int t = 0; t < 100; ++t) {
      Append(*observer, t, motion.positions_m.row(t));
      CHECK(observer->Answer()->has_value() == (t >= 10));
      CHECK(observer->leg_length_m().has_value() == (is_told || t >= 10));
    }
  }
}

TEST_CASE("Observer: measures the leg length over 1 s, then answers as with a given length",
          "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = Stream(150);
  const auto measured = Observe(model, {}, std::nullopt);
  std::optional<double> settled;
  for (int t = 0; t < 150; ++t) {
    Append(*measured, t, motion.positions_m.row(t));
    const core::Observed answer = Answer(*measured);
    if (t == 59) {
      settled = measured->leg_length_m();
      core::MarkerMotion second = motion;
      second.positions_m.conservativeResize(60, Eigen::NoChange);
      CHECK(*settled == *core::EstimateLegLength(PointScheme().set, second));
    }
    if (t >= 59) CHECK(measured->leg_length_m() == settled);
    if (t % 10 != 9) continue;
    const auto expected = Observe(model, {}, measured->leg_length_m());
    Append(*expected, 0, motion.positions_m.topRows(t + 1));
    CheckSame(answer, Answer(*expected));
  }
}

TEST_CASE("Observer: frames at another rate are resampled", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  const core::MarkerMotion motion = PointMotion(200, 1, 77, 120);
  const auto observer = Observe(model, {}, kLegLength_m, 120);
  Append(*observer, 0, motion.positions_m);
  auto halved = core::Resample(motion, 60);
  REQUIRE(halved.ok());
  const auto expected = Observe(model);
  Append(*expected, 0, halved->positions_m);
  CheckSame(Answer(*observer), Answer(*expected));
  CHECK(Answer(*observer).frame == 198);  // frame 199 is between two frames of the model
  const auto slow = Observe(model, {}, kLegLength_m, 25);
  Append(*slow, 0, motion.positions_m.topRows(40));
  CHECK(Answer(*slow).frame == 39);
}

TEST_CASE("Observer: invalid positions do no harm", "[core][observe]") {
  const core::Model model = PointModel(2, 2);
  core::ObserverOptions options;
  options.horizon_seconds = {0.2};
  const auto observer = Observe(model, options, std::nullopt);
  core::MarkerMotion motion = Stream(200);
  Hide(motion, 0, 80, 150);                               // one hip for a long time
  for (int m = 0; m < 6; ++m) Hide(motion, m, 100, 140);  // then all markers
  motion.positions_m.row(160).setConstant(5);             // all in one point
  motion.positions_m.row(161).setConstant(-1e5F);         // far away
  motion.positions_m.row(162) *= 1000;
  for (int t = 0; t < 200; ++t) {
    Append(*observer, t, motion.positions_m.row(t));
    const core::Observed answer = Answer(*observer);
    CHECK(std::isfinite(answer.state.probability));
    double sum = 0;
    for (const core::LabelScore& label : answer.labels) sum += label.probability;
    CHECK(sum == Approx(1));
    CHECK(answer.familiarity >= 0);
    CHECK(answer.familiarity <= 1);
  }
}

}  // namespace motiondb::tests::observer_stream_test
