#include "core/planning/robot_forces.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/planning/plan.h"
#include "tests/core/planning/flat_footed_robot.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::robot_forces_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

StandingFoot FootAt(const Vector2d& heel, const Vector2d& toe) {
  const Vector2d length = toe - heel;
  return {.joint = 0, .places = {heel, toe}, .across = 0.2 * Vector2d(-length.y(), length.x())};
}

TEST_CASE("ZeroMomentPoint: the wrench has no horizontal moment there", "[core][planning]") {
  const Wrench wrench{{30, -20, 400}, {50, -80, 7}};
  const auto point = ZeroMomentPoint(wrench);
  REQUIRE(point.has_value());
  const Vector3d moment = wrench.moment - Vector3d(point->x(), point->y(), 0).cross(wrench.force);
  CHECK(moment.head<2>().norm() < 1e-12);
  CHECK_FALSE(ZeroMomentPoint({{0, 0, -1}, {}}).has_value());
}

TEST_CASE("ShareWrench: the feet together exert the wrench", "[core][planning]") {
  const std::vector<StandingFoot> feet = {FootAt({0, 0.1}, {0.2, 0.1}),
                                          FootAt({0.3, -0.1}, {0.5, -0.15})};
  for (const Wrench& wrench : {Wrench{{30, -20, 400}, {5, -80, 7}},
                               Wrench{{1, 2, 300}, {900, 900, 0}}, Wrench{{1, 2, -3}, {4, 5, 6}}}) {
    Wrench sum;
    const auto shares = ShareWrench(wrench, feet);
    for (const Wrench& share : shares) sum += share;
    CHECK((sum.force - wrench.force).norm() < 1e-9);
    CHECK((sum.moment - wrench.moment).norm() < 1e-9);
    CHECK(ShareWrench(wrench, {feet[1]})[0].force == wrench.force);
  }
  // Above one foot's middle, that foot carries everything, without a moment about it.
  const Vector3d middle(0.1, 0.1, 0);
  const Vector3d force(0, 0, 400);
  const auto shares = ShareWrench({force, middle.cross(force)}, feet);
  CHECK((shares[0].force - force).norm() < 1e-9);
  CHECK(shares[1].force.norm() < 1e-9);
}

TEST_CASE("SupportMargin: inside, outside, and on one marker", "[core][planning]") {
  const StandingFoot left = FootAt({0, 0.1}, {0.2, 0.1});  // half as wide as 0.04
  const StandingFoot right = FootAt({0, -0.1}, {0.2, -0.1});
  CHECK(SupportMargin({left}, {0.1, 0.1}) == Approx(0.04));
  CHECK(SupportMargin({left}, {0.1, 0}) == Approx(-0.06));
  CHECK(SupportMargin({left, right}, {0.1, 0}) == Approx(0.1));
  CHECK(SupportMargin({left, right}, {0.5, 0.14}) == Approx(-0.3));
  StandingFoot toe = left;
  toe.places = {{0.2, 0.1}};
  CHECK(SupportMargin({toe}, {0.3, 0.1}) == Approx(-0.1));
  CHECK(SupportMargin({toe}, {0.2, 0.2}) == Approx(-0.06));
  toe.across = Vector2d::Zero();
  CHECK(SupportMargin({toe}, {0.2, 0.2}) == Approx(-0.1));
}

Body Robot() {
  auto body = Body::OfSkeleton(tests::WalkingDatabase(), tests::RobotScheme(),
                               tests::FlatFootedRobot(), true);
  INFO(body.status());
  REQUIRE(body.ok());
  return *std::move(body);
}

// All mass at the base, 0.05 m in front of its origin.
RobotDynamics HeavyBase() {
  const auto skeleton = tests::FlatFootedRobot();
  RobotDynamics dynamics;
  dynamics.max_speeds = dynamics.max_efforts =
      Eigen::RowVectorXd::Constant(skeleton->dof_count(), 1e9);
  dynamics.links.resize(static_cast<std::size_t>(skeleton->joint_count()));
  dynamics.links[0] = {.mass_kg = 10, .centre_m = {0.05, 0, 0}};
  return dynamics;
}

TEST_CASE("MeasureForces: standing on one leg, the joints carry the weight", "[core][planning]") {
  const Body body = Robot();
  const auto skeleton = tests::FlatFootedRobot();
  JointMotion joints{skeleton, 60, JointMatrix::Zero(30, skeleton->dof_count())};
  joints.angles.col(2).setConstant(tests::kRobotLeg_m + tests::kRobotAnkle_m);
  // The right knee is raised.
  joints.angles.col(skeleton->first_dof(skeleton->FindJoint("right_knee"))).setConstant(1);
  const auto markers = ApplyScheme(tests::RobotScheme(), joints, body.leg_length_m());
  REQUIRE(markers.ok());
  const ContactMatrix contacts = ContactMatrix::Constant(30, 4, false);  // low markers support
  const RobotForces forces = MeasureForces(body, HeavyBase(), joints, *markers, contacts);
  const double weight = 10 * 9.81;
  const auto effort = [&](const char* joint, int axis) {
    const int c = skeleton->first_dof(skeleton->FindJoint(joint)) + axis;
    for (const PeakEffort& peak : forces.efforts) {
      if (peak.coordinate == c) return peak.effort;
    }
    FAIL("no effort of " << joint);
    return 0.0;
  };
  CHECK(forces.efforts.size() == static_cast<std::size_t>(skeleton->dof_count() - 6));
  // The centre of mass is 0.05 m in front of the left leg and 0.07 m beside it.
  CHECK(effort("left_knee", 0) == Approx(0.05 * weight));
  CHECK(effort("left_ankle", 0) == Approx(0.05 * weight));
  CHECK(effort("left_ankle", 1) == Approx(0.07 * weight));
  CHECK(effort("right_knee", 0) == Approx(0).margin(1e-9));
  // Half of the sole's width is 0.18 of its length.
  REQUIRE(forces.balance.has_value());
  const double length = 0.28 * tests::kRobotLeg_m;
  CHECK(forces.balance->smallest_margin_m == Approx(0.18 * length - 0.07).margin(1e-6));
  CHECK(forces.balance->outside_seconds == Approx(forces.balance->supported_seconds));
}

TEST_CASE("MeasureForces: an accelerated base moves the zero-moment point", "[core][planning]") {
  const Body body = Robot();
  const auto skeleton = tests::FlatFootedRobot();
  JointMotion joints{skeleton, 60, JointMatrix::Zero(40, skeleton->dof_count())};
  const double height = tests::kRobotLeg_m + tests::kRobotAnkle_m;
  for (int t = 0; t < 40; ++t) {
    const double s = t / 60.0;
    joints.angles(t, 0) = 0.5 * 1.5 * s * s;  // 1.5 m/s^2 to the front
    joints.angles(t, 2) = height;
  }
  const auto markers = ApplyScheme(tests::RobotScheme(), joints, body.leg_length_m());
  REQUIRE(markers.ok());
  const ContactMatrix contacts = ContactMatrix::Constant(40, 4, true);
  const RobotForces forces = MeasureForces(body, HeavyBase(), joints, *markers, contacts);
  REQUIRE(forces.balance.has_value());
  // The point is behind the centre of mass by z a / g; the heels are 0.08 leg lengths behind.
  const double behind = height * 1.5 / 9.81 - 0.05;
  CHECK(forces.balance->smallest_margin_m ==
        Approx(0.08 * tests::kRobotLeg_m - behind).margin(1e-5));
}

TEST_CASE("Plan: forces are reported if masses are known", "[core][planning]") {
  PlanProblem problem;
  problem.start.clip = ClipMoment{"straight", 0.2};
  problem.goal = {1, 0, 0};
  problem.skeleton = tests::FlatFootedRobot();
  problem.flat_soles = true;
  auto dynamics = std::make_shared<RobotDynamics>(HeavyBase());
  problem.dynamics = dynamics;
  const auto answer = PlanMotion(tests::WalkingDatabase(), tests::RobotScheme(), problem);
  REQUIRE(answer.ok());
  REQUIRE(answer->motions.front().forces.has_value());
  const RobotForces& forces = *answer->motions.front().forces;
  REQUIRE(forces.balance.has_value());
  CHECK(forces.balance->supported_seconds > 0.5 * answer->motions.front().quality.duration_seconds);
  CHECK(std::abs(forces.balance->smallest_margin_m) < 1);
  dynamics->links.clear();
  const auto massless = PlanMotion(tests::WalkingDatabase(), tests::RobotScheme(), problem);
  REQUIRE(massless.ok());
  CHECK_FALSE(massless->motions.front().forces.has_value());
}

}  // namespace
}  // namespace motiondb::core::robot_forces_test
