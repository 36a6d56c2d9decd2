#include "core/planning/motion_quality.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/model/model.h"
#include "core/planning/plan.h"
#include "core/recognition/recognize.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::tests::motion_quality_test {
namespace {

constexpr double kRate = 50;
constexpr double kLeg_m = 0.9;

// Markers 0 (heel) and 1 (toe) of one foot, at rest at 0.04 leg lengths.
core::Feet OneFoot() {
  core::Foot foot;
  foot.contact_markers = {0, 1};
  foot.rest_heights = {0.04f, 0.04f};
  return {foot};
}

core::MarkerMotion Still(int frames) {
  core::MarkerMotion motion{{"heel", "toe"}, kRate, core::FrameMatrix::Zero(frames, 6)};
  motion.positions_m.col(2).setConstant(0.04f * static_cast<float>(kLeg_m));
  motion.positions_m.col(5).setConstant(0.04f * static_cast<float>(kLeg_m));
  return motion;
}

core::MotionQuality Measure(const core::MarkerMotion& motion, const core::ContactMatrix& contacts) {
  return core::MeasureQuality(OneFoot(), motion, contacts, kLeg_m, nullptr);
}

}  // namespace

TEST_CASE("MeasureQuality: foot slide is the speed of a foot in contact", "[core][planning]") {
  core::MarkerMotion motion = Still(101);
  for (int t = 0; t < 101; ++t) {
    motion.positions_m(t, 0) = 0.1f * static_cast<float>(t / kRate);  // heel: 0.1 m/s
    motion.positions_m(t, 4) = 0.3f * static_cast<float>(t / kRate);  // toe: 0.3 m/s
  }
  core::ContactMatrix contacts = core::ContactMatrix::Constant(101, 2, true);
  CHECK(Measure(motion, contacts).foot_slide_cm_per_s == Approx(10).epsilon(1e-4));
  contacts.col(0).head(51).setConstant(false);  // half of the time only the toe is in contact
  CHECK(Measure(motion, contacts).foot_slide_cm_per_s == Approx(20).epsilon(0.02));
  contacts.setConstant(false);
  CHECK(Measure(motion, contacts).foot_slide_cm_per_s == 0);
  contacts.row(3).setConstant(true);  // a single frame has no speed
  CHECK(Measure(motion, contacts).foot_slide_cm_per_s == 0);
}

TEST_CASE("MeasureQuality: a foot that rotates about its toe does not slide", "[core][planning]") {
  core::MarkerMotion motion = Still(60);
  for (int t = 0; t < 60; ++t) {
    motion.positions_m(t, 0) = 0.2f * std::cos(0.03f * static_cast<float>(t));
    motion.positions_m(t, 1) = 0.2f * std::sin(0.03f * static_cast<float>(t));
  }
  CHECK(Measure(motion, core::ContactMatrix::Constant(60, 2, true)).foot_slide_cm_per_s == 0);
}

TEST_CASE("MeasureQuality: penetration is below the rest height, in any frame",
          "[core][planning]") {
  core::MarkerMotion motion = Still(20);
  const core::ContactMatrix contacts = core::ContactMatrix::Constant(20, 2, false);
  CHECK(Measure(motion, contacts).floor_penetration_cm == Approx(0).margin(1e-5));
  motion.positions_m(7, 5) -= 0.013f;
  motion.positions_m(9, 2) = std::nanf("");
  CHECK(Measure(motion, contacts).floor_penetration_cm == Approx(1.3).epsilon(1e-3));
}

TEST_CASE("MeasureQuality: marker jerk is the root mean square over markers", "[core][planning]") {
  core::MarkerMotion motion = Still(40);
  for (int t = 0; t < 40; ++t) {
    motion.positions_m(t, 3) = 2 * static_cast<float>(std::pow(t / kRate, 3));  // 12 m/s^3
  }
  const core::ContactMatrix contacts = core::ContactMatrix::Constant(40, 2, false);
  CHECK(Measure(motion, contacts).peak_marker_jerk_m_s3 ==
        Approx(12 / std::numbers::sqrt2).epsilon(0.02));
  CHECK(Measure(Still(3), core::ContactMatrix::Constant(3, 2, true)).peak_marker_jerk_m_s3 == 0);
  CHECK(Measure(Still(0), core::ContactMatrix(0, 2)).foot_slide_cm_per_s == 0);
}

TEST_CASE("MeasureQuality: joint speed and jerk ignore full turns and translations",
          "[core][planning]") {
  std::vector<core::Joint> joints(2);
  joints[0].name = "root";
  joints[0].dofs = {{.kind = core::Dof::Kind::kTranslation}, {.kind = core::Dof::Kind::kRotation}};
  joints[1].name = "child";
  joints[1].parent = 0;
  joints[1].dofs = {{.kind = core::Dof::Kind::kRotation, .axis = Eigen::Vector3d::UnitZ()}};
  auto skeleton = core::Skeleton::Create("one", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion motion{std::make_shared<core::Skeleton>(*std::move(skeleton)), kRate,
                           core::JointMatrix::Zero(80, 3)};
  for (int t = 0; t < 80; ++t) {
    const double s = t / kRate;
    motion.angles(t, 0) = 100 * s * s * s;
    motion.angles(t, 1) = std::remainder(4 * s, 2 * std::numbers::pi);
    motion.angles(t, 2) = 0.5 * s * s * s;  // 3 rad/s^3
  }
  const core::MotionQuality quality =
      core::MeasureQuality({}, Still(80), core::ContactMatrix(80, 0), kLeg_m, &motion);
  CHECK(quality.peak_joint_speed_rad_s == Approx(4));
  CHECK(quality.peak_joint_jerk_rad_s3 == Approx(3).epsilon(1e-4));
}

TEST_CASE("MeasureQuality: a slow rotation through gimbal lock has a low speed",
          "[core][planning]") {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  std::vector<core::Joint> joints(1);
  joints[0].name = "shoulder";
  for (const Vector3d axis : {Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY()}) {
    joints[0].dofs.push_back({.kind = core::Dof::Kind::kRotation, .axis = axis});
  }
  auto skeleton = core::Skeleton::Create("one", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion motion{std::make_shared<core::Skeleton>(*std::move(skeleton)), kRate,
                           core::JointMatrix::Zero(60, 3)};
  // 1 rad/s about an axis that takes the second angle through 90 degrees.
  const Vector3d axis = Vector3d(1, 0.02, 0.03).normalized();
  double fastest_angle = 0;
  for (int t = 0; t < 60; ++t) {
    const Eigen::Matrix3d turn = AngleAxisd(1.1 + t / kRate, axis).toRotationMatrix();
    motion.angles.row(t) << std::atan2(-turn(0, 1), turn(1, 1)), std::asin(turn(2, 1)),
        std::atan2(-turn(2, 0), turn(2, 2));
    if (t == 0) continue;
    fastest_angle =
        std::max(fastest_angle, kRate * std::abs(motion.angles(t, 0) - motion.angles(t - 1, 0)));
  }
  REQUIRE(fastest_angle > 20);
  const core::MotionQuality quality =
      core::MeasureQuality({}, Still(60), core::ContactMatrix(60, 0), kLeg_m, &motion);
  CHECK(quality.peak_joint_speed_rad_s == Approx(1));
  CHECK(quality.peak_joint_jerk_rad_s3 == Approx(0).margin(1e-5));
}

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

}  // namespace motiondb::tests::motion_quality_test
