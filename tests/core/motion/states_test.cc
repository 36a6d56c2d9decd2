#include "core/motion/states.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/synthetic_states.h"

namespace motiondb::tests::states_test {
namespace {

// Four markers (left and right hip, left knee and ankle) that walk along `heading` (rad) at `speed`
// (m/s), sampled at `rate` (Hz).
core::MarkerMotion Walk(double heading, double speed, double rate, int frames) {
  core::MarkerMotion motion{{"m0", "m1", "m2", "m3"}, rate, core::FrameMatrix(frames, 12)};
  const Eigen::Rotation2Dd turn(heading);
  const Eigen::Vector3d body[] = {{0, 0.1, 0.9}, {0, -0.1, 0.9}, {0.05, 0.1, 0.5}, {0, 0.1, 0.1}};
  for (int t = 0; t < frames; ++t) {
    for (int m = 0; m < 4; ++m) {
      Eigen::Vector3d p = body[m];
      p.x() += speed * t / rate;
      p.head<2>() = turn * p.head<2>();
      motion.positions_m.row(t).segment<3>(3 * m) = p.cast<float>().transpose();
    }
  }
  return motion;
}

const core::MarkerSet kSet = SmallMarkerSet(4);

core::StateSequence States(const core::MarkerMotion& motion) {
  auto states = core::ComputeStates(kSet, motion);
  INFO(states.status());
  REQUIRE(states.ok());
  return *std::move(states);
}

}  // namespace

TEST_CASE("ComputeStates: positions and velocities in the reference frame, in leg lengths",
          "[core][motion]") {
  const double leg = std::hypot(0.05, 0.4) + std::hypot(0.05, 0.4);
  for (const double heading : {0.0, 1.0, std::numbers::pi, -2.5}) {
    const core::StateSequence states = States(Walk(heading, 1.2, 60, 20));
    CHECK(states.leg_length_m == Approx(leg).epsilon(1e-5));
    for (int t = 0; t < 20; ++t) {
      const double travelled = 1.2 * t / 60;
      CHECK(states.root_path(t, 0) == Approx(travelled * std::cos(heading)).margin(1e-5));
      CHECK(states.root_path(t, 1) == Approx(travelled * std::sin(heading)).margin(1e-5));
      CHECK(std::remainder(states.root_path(t, 2) - heading, 2 * std::numbers::pi) ==
            Approx(0).margin(1e-5));
      const Eigen::RowVectorXf knee = states.states.row(t).segment<6>(12);
      CHECK(knee[0] == Approx(0.05 / leg).margin(1e-5));
      CHECK(knee[1] == Approx(0.1 / leg).margin(1e-5));
      CHECK(knee[2] == Approx(0.5 / leg).margin(1e-5));
      CHECK(knee[3] == Approx(1.2 / leg).margin(1e-3));  // world velocity: includes root motion
      CHECK(knee[4] == Approx(0).margin(1e-3));
      CHECK(knee[5] == Approx(0).margin(1e-3));
    }
  }
}

TEST_CASE("WorldPositions: inverts ComputeStates", "[core][motion]") {
  const core::MarkerMotion motion = Walk(0.7, 1.5, 60, 30);
  CHECK(core::WorldPositions(States(motion)).isApprox(motion.positions_m, 1e-5f));
}

TEST_CASE(
    "ComputeStates: a missing marker stays missing, and neighbouring frames have one-sided "
    "velocities",
    "[core][motion]") {
  core::MarkerMotion motion = Walk(0, 1, 60, 10);
  motion.positions_m.row(4).segment<3>(6).setConstant(std::nanf(""));
  const core::StateSequence states = States(motion);
  CHECK(std::isnan(states.states(4, 12)));
  CHECK(std::isfinite(states.states(3, 15)));
  CHECK(states.states(3, 15) == Approx(states.states(2, 15)).epsilon(1e-3));
  CHECK(states.states(5, 15) == Approx(states.states(6, 15)).epsilon(1e-3));
}

TEST_CASE("ReferenceFrames: interpolated if hips are missing or one is above the other",
          "[core][motion]") {
  core::MarkerMotion motion = Walk(0.5, 1, 60, 11);
  motion.positions_m.row(3).segment<3>(0).setConstant(std::nanf(""));
  motion.positions_m.row(6).segment<3>(0) = motion.positions_m.row(6).segment<3>(3);
  motion.positions_m(6, 2) += 0.2f;
  const auto path = core::ReferenceFrames(kSet, motion);
  REQUIRE(path.ok());
  for (int t = 0; t < 11; ++t) CHECK((*path)(t, 2) == Approx(0.5).margin(1e-4));
  CHECK((*path)(3, 0) == Approx(0.5 * ((*path)(2, 0) + (*path)(4, 0))));

  motion.positions_m.leftCols<3>().setConstant(std::nanf(""));
  CHECK(core::ReferenceFrames(kSet, motion).status().code() == absl::StatusCode::kInvalidArgument);
}

TEST_CASE("ReferenceFrames: heading is continuous through full turns", "[core][motion]") {
  core::MarkerMotion motion = Walk(0, 0, 60, 200);
  for (int t = 0; t < 200; ++t) {
    const Eigen::Rotation2Df turn(0.1f * static_cast<float>(t));
    for (int m = 0; m < 4; ++m) {
      motion.positions_m.row(t).segment<2>(3 * m) =
          (turn * motion.positions_m.row(t).segment<2>(3 * m).transpose()).transpose();
    }
  }
  const auto path = core::ReferenceFrames(kSet, motion);
  REQUIRE(path.ok());
  CHECK((*path)(199, 2) == Approx(19.9).margin(1e-3));
}

TEST_CASE("Resample: preserves smooth motion", "[core][motion]") {
  core::MarkerMotion fast = Walk(0, 0, 120, 241);
  for (int t = 0; t < 241; ++t) {
    fast.positions_m(t, 0) = std::sin(2 * static_cast<float>(std::numbers::pi) * t / 120);
  }
  for (const double rate : {25.0, 30.0, 60.0, 100.0, 119.88, 240.0}) {
    const auto resampled = core::Resample(fast, rate);
    REQUIRE(resampled.ok());
    CHECK(resampled->positions_m.rows() ==
          static_cast<Eigen::Index>(std::floor(2 * rate + 1e-6)) + 1);
    for (Eigen::Index t = 0; t < resampled->positions_m.rows(); ++t) {
      CHECK(resampled->positions_m(t, 0) ==
            Approx(std::sin(2 * std::numbers::pi * static_cast<double>(t) / rate)).margin(4e-3));
    }
  }
  CHECK_FALSE(core::Resample(fast, 0).ok());
  CHECK_FALSE(core::Resample(fast, std::nan("")).ok());
  CHECK_FALSE(core::Resample(Walk(0, 0, 60, 1), 30).ok());
}

TEST_CASE("Resample: keeps recorded frames next to missing ones", "[core][motion]") {
  core::MarkerMotion motion = Walk(0, 1, 120, 9);
  motion.positions_m.row(3).setConstant(std::nanf(""));
  const auto half = core::Resample(motion, 60);
  REQUIRE(half.ok());
  CHECK(half->positions_m.allFinite());
  const auto upsampled = core::Resample(motion, 360);
  REQUIRE(upsampled.ok());
  CHECK(upsampled->positions_m.row(7).hasNaN());  // between frames 2 and 3
  CHECK(
      upsampled->positions_m.row(4).allFinite());  // between 1 and 2: linear, because 3 is missing
}

TEST_CASE("FillGaps: short gaps are interpolated, long ones reported", "[core][motion]") {
  core::MarkerMotion motion = Walk(0, 1.2, 60, 60);
  const core::FrameMatrix whole = motion.positions_m;
  for (const int t : {0, 1, 10, 11, 12, 59}) {
    motion.positions_m.row(t).segment<3>(6).setConstant(std::nanf(""));
  }
  const auto notes = core::FillGaps(0.5, motion);
  REQUIRE(notes.ok());
  REQUIRE(notes->size() == 1);
  CHECK_THAT(notes->front(), Catch::Matchers::Contains("6 frames of 'm2'"));
  CHECK((motion.positions_m - whole).middleRows(2, 57).norm() < 1e-4);
  CHECK(motion.positions_m.allFinite());

  motion.positions_m.middleRows(5, 40).middleCols<3>(6).setConstant(std::nanf(""));
  const auto refused = core::FillGaps(0.5, motion);
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(std::string(refused.status().message()),
             Catch::Matchers::Contains("'m2'") && Catch::Matchers::Contains("frame 6 to 45"));
  motion.positions_m.middleCols<3>(6).setConstant(std::nanf(""));
  CHECK_THAT(std::string(core::FillGaps(0.5, motion).status().message()),
             Catch::Matchers::Contains("all 60 frames"));
}

TEST_CASE("EstimateLegLength: uses whole legs, otherwise height", "[core][motion]") {
  const core::MarkerMotion motion = Walk(0, 1, 60, 5);
  CHECK(*core::EstimateLegLength(kSet, motion) == Approx(2 * std::hypot(0.05, 0.4)).epsilon(1e-5));
  core::MarkerSet bare = kSet;
  bare.landmarks.legs.clear();
  const auto height = core::EstimateLegLength(bare, motion);
  REQUIRE(height.ok());
  CHECK(*height == Approx(0.4));
  const auto given = core::ComputeStates(kSet, motion, 1.7);
  REQUIRE(given.ok());
  CHECK(given->leg_length_m == 1.7);
  CHECK_FALSE(core::ComputeStates(kSet, motion, -1).ok());
  CHECK_FALSE(core::ComputeStates(kSet, motion, std::nan("")).ok());
}

}  // namespace motiondb::tests::states_test
