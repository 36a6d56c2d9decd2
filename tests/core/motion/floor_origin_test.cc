// A motion far from the origin has the states of the motion at the origin.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "core/motion/motion_floor.h"
#include "core/motion/states.h"

namespace motiondb::core::floor_origin_test {
namespace {

// A body that walks ahead and turns, with swinging legs; its root starts at `place`.
JointMotion Walk(const Eigen::Vector2d& place, double frame_rate_hz) {
  const auto moves = [] {
    std::vector<Dof> dofs;
    for (int axis = 0; axis < 3; ++axis) {
      dofs.push_back({.kind = Dof::Kind::kTranslation, .axis = Eigen::Vector3d::Unit(axis)});
    }
    dofs.push_back({.kind = Dof::Kind::kRotation, .axis = Eigen::Vector3d::UnitZ()});
    return dofs;
  };
  const std::vector<Dof> bends{{.kind = Dof::Kind::kRotation, .axis = Eigen::Vector3d::UnitY()}};
  std::vector<Joint> joints{{.name = "Hips", .parent = -1, .dofs = moves()}};
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
  auto skeleton = Skeleton::Create("walker", std::move(joints));
  REQUIRE(skeleton.ok());
  JointMotion motion{.skeleton = std::make_shared<const Skeleton>(*std::move(skeleton)),
                     .frame_rate_hz = frame_rate_hz};
  motion.angles.resize(90, motion.skeleton->dof_count());
  for (Eigen::Index f = 0; f < motion.angles.rows(); ++f) {
    const double t = static_cast<double>(f) / frame_rate_hz;
    motion.angles.row(f) << place.x() + 0.3 + 1.2 * t, place.y() - 0.2 + 0.1 * t, 0.9, 0.4 * t,
        0.5 * std::sin(6 * t), 0.3 * std::cos(6 * t), -0.5 * std::sin(6 * t), 0.3;
  }
  return motion;
}

StateSequence StatesOf(const Motion& motion) {
  const auto scheme = SourceScheme(motion);
  REQUIRE(scheme.ok());
  const auto states = Represent(*scheme, motion, 60, kObservation);
  INFO(states.status());
  REQUIRE(states.ok());
  return *states;
}

TEST_CASE("Represent: a clip anywhere has the states of a clip at the origin", "[motion]") {
  for (const double rate : {60.0, 120.0, 25.0}) {
    const StateSequence here = StatesOf(Walk({0, 0}, rate));
    for (const Eigen::Vector2d& place :
         {Eigen::Vector2d(90'000, 0), Eigen::Vector2d(-63'000, 63'007.3)}) {
      CAPTURE(rate, place.transpose());
      const StateSequence there = StatesOf(Walk(place, rate));
      REQUIRE(there.states.rows() == here.states.rows());
      CHECK(std::abs(there.leg_length_m - here.leg_length_m) < 1e-6);
      // Velocities are differences of floats within 16 m, multiplied by the frame rate.
      CHECK((there.states - here.states).cwiseAbs().maxCoeff() < 2e-4F);
      const Eigen::MatrixXd moved = there.root_path.leftCols<2>().rowwise() - place.transpose();
      CHECK((moved - here.root_path.leftCols<2>()).cwiseAbs().maxCoeff() < 1e-5);
      CHECK((there.root_path.col(2) - here.root_path.col(2)).cwiseAbs().maxCoeff() < 1e-5);
      // Also the velocity of the last frame of a past.
      const StateSequence past_here = PastAt(here, 20, 10);
      const StateSequence past_there = PastAt(there, 20, 10);
      CHECK((past_there.states - past_here.states).cwiseAbs().maxCoeff() < 1e-3F);
    }
  }
}

TEST_CASE("Represent: impossible positions are refused with their frame", "[motion]") {
  const Motion far = Walk({2e5, 0}, 60);
  const auto scheme = SourceScheme(far);
  REQUIRE(scheme.ok());
  const auto refused = Represent(*scheme, far, 60, kObservation);
  CHECK(refused.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK(std::string(refused.status().message()).find("(20000") != std::string::npos);
}

TEST_CASE("FloorOrigin: motion near the origin is unchanged", "[motion]") {
  CHECK(FloorOrigin(Walk({0, 0}, 60)) == Eigen::Vector2d(0, 0));
  CHECK(FloorOrigin(Walk({7, -7}, 60)) == Eigen::Vector2d(0, 0));
  CHECK(FloorOrigin(Walk({90'000, 0}, 60)) == Eigen::Vector2d(90'000, 0));
  CHECK(NearestCorner({std::nan(""), 5}) == Eigen::Vector2d(0, 0));
}

}  // namespace
}  // namespace motiondb::core::floor_origin_test
