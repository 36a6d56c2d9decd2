#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/format/marker_set_file.h"
#include "core/motion/motion_floor.h"
#include "core/motion/states.h"

namespace motiondb::tests::floor_level_test {
namespace {

constexpr double kLeg_m = 0.9;
constexpr double kRate_hz = 60;
constexpr double kAnkle_m = 0.08 * kLeg_m;

const core::MarkerScheme& Legs() {
  static const core::MarkerScheme scheme{{"legs",
                                          {"LHip", "RHip", "LKnee", "RKnee", "LAnkle", "RAnkle"},
                                          {0, 1, {{0, 2, 4}, {1, 3, 5}}}},
                                         {},
                                         {}};
  return scheme;
}

// Two legs of the length kLeg_m that walk along x: each foot stands for half a second, then swings
// over half a second. The standing ankle is at `ankle_m`, or never stands if `stands` is false.
core::MarkerMotion Walk(double ankle_m, bool stands = true) {
  constexpr int kFrames = 240;
  core::MarkerMotion motion{Legs().set.markers, kRate_hz, core::FrameMatrix(kFrames, 18)};
  for (int t = 0; t < kFrames; ++t) {
    const double seconds = t / kRate_hz;
    for (const int side : {0, 1}) {
      const double phase = seconds + 0.5 * side;
      const double swing = stands ? std::max(0.0, std::fmod(phase, 1.0) - 0.5) / 0.5 : phase;
      const double x = stands ? std::floor(phase) + swing : 1.2 * seconds;
      const double lift = 0.15 * (stands ? std::sin(M_PI * swing) : 1);
      const Eigen::Vector3d ankle(x, side == 0 ? 0.1 : -0.1, ankle_m + lift);
      const Eigen::Vector3d hip(seconds, ankle.y(), ankle_m + 0.95 * kLeg_m);
      const auto put = [&](int marker, const Eigen::Vector3d& at) {
        motion.positions_m.row(t).segment<3>(3 * marker) = at.cast<float>().transpose();
      };
      put(side, hip);
      put(2 + side, (hip + ankle) / 2);
      put(4 + side, ankle);
    }
  }
  return motion;
}

}  // namespace

TEST_CASE("FloorLevel: the level under standing ankles, wherever the file has its floor",
          "[core][motion]") {
  for (const double height_m : {-0.1, 0.0, 0.04, 0.1}) {
    CAPTURE(height_m);
    const auto level = core::FloorLevel(Legs().set, Walk(kAnkle_m + height_m), kLeg_m);
    REQUIRE(level.has_value());
    CHECK(*level == Approx(height_m).margin(0.005));
  }
}

TEST_CASE("FloorLevel: none without standing feet, far from z = 0 or without legs",
          "[core][motion]") {
  CHECK_FALSE(core::FloorLevel(Legs().set, Walk(kAnkle_m, false), kLeg_m).has_value());
  CHECK_FALSE(core::FloorLevel(Legs().set, Walk(kAnkle_m + 0.2), kLeg_m).has_value());
  core::MarkerMotion short_motion = Walk(kAnkle_m);
  short_motion.positions_m.conservativeResize(3, Eigen::NoChange);
  CHECK_FALSE(core::FloorLevel(Legs().set, short_motion, kLeg_m).has_value());
  core::MarkerSet hips{"hips", {"LHip", "RHip"}, {0, 1, {}}};
  core::MarkerMotion no_legs = Walk(kAnkle_m + 0.05);
  const core::FrameMatrix before = no_legs.positions_m;
  CHECK(core::MoveToFloor(hips, kLeg_m, no_legs) == 0);
  CHECK(no_legs.positions_m == before);
}

TEST_CASE("FloorLevel: missing markers do not count", "[core][motion]") {
  core::MarkerMotion motion = Walk(kAnkle_m + 0.05);
  motion.positions_m.middleCols<3>(12).topRows(100).setConstant(std::nanf(""));
  CHECK(core::FloorLevel(Legs().set, motion, kLeg_m).value() == Approx(0.05).margin(0.005));
}

TEST_CASE("Represent: states do not depend on the height of the file's floor", "[core][motion]") {
  for (const auto& cleaning : {core::Cleaning(core::GlitchPolicy::kRepair), core::kObservation}) {
    const auto here = core::Represent(Legs(), Walk(kAnkle_m), kRate_hz, cleaning, kLeg_m);
    const core::MarkerMotion motion = Walk(kAnkle_m + 0.06);
    const auto above = core::Represent(Legs(), motion, kRate_hz, cleaning, kLeg_m);
    REQUIRE((here.ok() && above.ok()));
    CHECK((here->states - above->states).cwiseAbs().maxCoeff() < 1e-5);
    // Answers to an observation are in its world; a stored clip is moved to its floor.
    const double left_m = cleaning ? 0.06 : 0;
    const core::FrameMatrix difference = motion.positions_m - core::WorldPositions(*above);
    for (Eigen::Index c = 0; c < difference.cols(); ++c) {
      CAPTURE(c);
      CHECK(difference.col(c).mean() == Approx(c % 3 == 2 ? left_m : 0).margin(0.005));
    }
    const core::StateSequence past = core::PastAt(*above, 100, 10);
    CHECK(past.floor_m == above->floor_m);
  }
}

}  // namespace motiondb::tests::floor_level_test
