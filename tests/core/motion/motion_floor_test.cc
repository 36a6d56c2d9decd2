#include "core/motion/motion_floor.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "core/format/marker_set_file.h"
#include "core/motion/states.h"

namespace motiondb::tests::motion_floor_test {
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
core::MarkerMotion WalkingLegs(double ankle_m, bool stands = true) {
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

// A body that walks ahead and turns, with swinging legs; its root starts at `place`.
core::JointMotion WalkingBody(const Eigen::Vector2d& place, double frame_rate_hz) {
  const auto moves = [] {
    std::vector<core::Dof> dofs;
    for (int axis = 0; axis < 3; ++axis) {
      dofs.push_back({.kind = core::Dof::Kind::kTranslation, .axis = Eigen::Vector3d::Unit(axis)});
    }
    dofs.push_back({.kind = core::Dof::Kind::kRotation, .axis = Eigen::Vector3d::UnitZ()});
    return dofs;
  };
  const std::vector<core::Dof> bends{
      {.kind = core::Dof::Kind::kRotation, .axis = Eigen::Vector3d::UnitY()}};
  std::vector<core::Joint> joints{{.name = "Hips", .parent = -1, .dofs = moves()}};
  for (const int side : {1, -1}) {
    const std::string name = side > 0 ? "Left" : "Right";
    const int hip = static_cast<int>(joints.size());
    joints.push_back({.name = name + "UpLeg",
                      .parent = 0,
                      .offset_m = Eigen::Vector3d(0, 0.1 * side, 0),
                      .dofs = bends});
    joints.push_back(
        {.name = name + "Leg", .parent = hip, .offset_m = {0, 0, -0.45}, .dofs = bends});
    joints.push_back({.name = name + "Foot", .parent = hip + 1, .offset_m = {0, 0, -0.45}});
  }
  auto skeleton = core::Skeleton::Create("walker", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion motion{.skeleton = std::make_shared<const core::Skeleton>(*std::move(skeleton)),
                           .frame_rate_hz = frame_rate_hz};
  motion.angles.resize(90, motion.skeleton->dof_count());
  for (Eigen::Index f = 0; f < motion.angles.rows(); ++f) {
    const double t = static_cast<double>(f) / frame_rate_hz;
    motion.angles.row(f) << place.x() + 0.3 + 1.2 * t, place.y() - 0.2 + 0.1 * t, 0.9, 0.4 * t,
        0.5 * std::sin(6 * t), 0.3 * std::cos(6 * t), -0.5 * std::sin(6 * t), 0.3;
  }
  return motion;
}

core::StateSequence StatesOf(const core::Motion& motion) {
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.ok());
  const auto states = core::Represent(*scheme, motion, 60, core::kObservation);
  INFO(states.status());
  REQUIRE(states.ok());
  return *states;
}

}  // namespace

TEST_CASE("FloorLevel: the level under standing ankles, wherever the file has its floor",
          "[core][motion]") {
  for (const double height_m : {-0.1, 0.0, 0.04, 0.1}) {
    CAPTURE(height_m);
    const auto level = core::FloorLevel(Legs().set, WalkingLegs(kAnkle_m + height_m), kLeg_m);
    REQUIRE(level.has_value());
    CHECK(*level == Approx(height_m).margin(0.005));
  }
}

TEST_CASE("FloorLevel: none without standing feet, far from z = 0 or without legs",
          "[core][motion]") {
  CHECK_FALSE(core::FloorLevel(Legs().set, WalkingLegs(kAnkle_m, false), kLeg_m).has_value());
  CHECK_FALSE(core::FloorLevel(Legs().set, WalkingLegs(kAnkle_m + 0.2), kLeg_m).has_value());
  core::MarkerMotion short_motion = WalkingLegs(kAnkle_m);
  short_motion.positions_m.conservativeResize(3, Eigen::NoChange);
  CHECK_FALSE(core::FloorLevel(Legs().set, short_motion, kLeg_m).has_value());
  core::MarkerSet hips{"hips", {"LHip", "RHip"}, {0, 1, {}}};
  core::MarkerMotion no_legs = WalkingLegs(kAnkle_m + 0.05);
  const core::FrameMatrix before = no_legs.positions_m;
  CHECK(core::MoveToFloor(hips, kLeg_m, no_legs) == 0);
  CHECK(no_legs.positions_m == before);
}

TEST_CASE("FloorLevel: missing markers do not count", "[core][motion]") {
  core::MarkerMotion motion = WalkingLegs(kAnkle_m + 0.05);
  motion.positions_m.middleCols<3>(12).topRows(100).setConstant(std::nanf(""));
  CHECK(core::FloorLevel(Legs().set, motion, kLeg_m).value() == Approx(0.05).margin(0.005));
}

TEST_CASE("Represent: states do not depend on the height of the file's floor", "[core][motion]") {
  for (const auto& cleaning : {core::Cleaning(core::GlitchPolicy::kRepair), core::kObservation}) {
    const auto here = core::Represent(Legs(), WalkingLegs(kAnkle_m), kRate_hz, cleaning, kLeg_m);
    const core::MarkerMotion motion = WalkingLegs(kAnkle_m + 0.06);
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

TEST_CASE("Represent: a clip anywhere has the states of a clip at the origin", "[motion]") {
  for (const double rate : {60.0, 120.0, 25.0}) {
    const core::StateSequence here = StatesOf(WalkingBody({0, 0}, rate));
    for (const Eigen::Vector2d& place :
         {Eigen::Vector2d(90'000, 0), Eigen::Vector2d(-63'000, 63'007.3)}) {
      CAPTURE(rate, place.transpose());
      const core::StateSequence there = StatesOf(WalkingBody(place, rate));
      REQUIRE(there.states.rows() == here.states.rows());
      CHECK(std::abs(there.leg_length_m - here.leg_length_m) < 1e-6);
      // Velocities are differences of floats within 16 m, multiplied by the frame rate.
      CHECK((there.states - here.states).cwiseAbs().maxCoeff() < 2e-4F);
      const Eigen::MatrixXd moved = there.root_path.leftCols<2>().rowwise() - place.transpose();
      CHECK((moved - here.root_path.leftCols<2>()).cwiseAbs().maxCoeff() < 1e-5);
      CHECK((there.root_path.col(2) - here.root_path.col(2)).cwiseAbs().maxCoeff() < 1e-5);
      // Also the velocity of the last frame of a past.
      const core::StateSequence past_here = core::PastAt(here, 20, 10);
      const core::StateSequence past_there = core::PastAt(there, 20, 10);
      CHECK((past_there.states - past_here.states).cwiseAbs().maxCoeff() < 1e-3F);
    }
  }
}

TEST_CASE("Represent: impossible positions are refused with their frame", "[motion]") {
  const core::Motion far = WalkingBody({2e5, 0}, 60);
  const auto scheme = core::SourceScheme(far);
  REQUIRE(scheme.ok());
  const auto refused = core::Represent(*scheme, far, 60, core::kObservation);
  CHECK(refused.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK(std::string(refused.status().message()).find("(20000") != std::string::npos);
}

TEST_CASE("FloorOrigin: motion near the origin is unchanged", "[motion]") {
  CHECK(core::FloorOrigin(WalkingBody({0, 0}, 60)) == Eigen::Vector2d(0, 0));
  CHECK(core::FloorOrigin(WalkingBody({7, -7}, 60)) == Eigen::Vector2d(0, 0));
  CHECK(core::FloorOrigin(WalkingBody({90'000, 0}, 60)) == Eigen::Vector2d(90'000, 0));
  CHECK(core::NearestCorner({std::nan(""), 5}) == Eigen::Vector2d(0, 0));
}

}  // namespace motiondb::tests::motion_floor_test
