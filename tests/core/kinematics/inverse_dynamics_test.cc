#include "core/kinematics/inverse_dynamics.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/forward_kinematics.h"
#include "core/motion/motion.h"

namespace motiondb::core::inverse_dynamics_test {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.81;
constexpr double kRate = 1000;

Dof Slide(const Vector3d& axis) { return {.kind = Dof::Kind::kTranslation, .axis = axis}; }
Dof Turn(const Vector3d& axis) { return {.kind = Dof::Kind::kRotation, .axis = axis}; }

Skeleton Make(std::vector<Joint> joints) {
  auto skeleton = Skeleton::Create("robot", std::move(joints));
  INFO(skeleton.status());
  REQUIRE(skeleton.ok());
  return *std::move(skeleton);
}

// Two hanging rods in the plane of x and z, joints about y.
Skeleton DoublePendulum(double upper_m) {
  return Make({{.name = "upper", .dofs = {Turn(Vector3d::UnitY())}},
               {.name = "lower",
                .parent = 0,
                .offset_m = {0, 0, -upper_m},
                .dofs = {Turn(Vector3d::UnitY())}}});
}

LinkInertia PointMass(double mass_kg, double below_m) {
  return {.mass_kg = mass_kg, .centre_m = {0, 0, -below_m}};
}

// A tree with a floating base, joints of several kinds, and links with any inertia.
Skeleton Robot() {
  return Make(
      {{.name = "base",
        .dofs = {Slide(Vector3d::UnitX()), Slide(Vector3d::UnitY()), Slide(Vector3d::UnitZ()),
                 Turn(Vector3d::UnitZ()), Turn(Vector3d::UnitY()), Turn(Vector3d::UnitX())}},
       {.name = "hip",
        .parent = 0,
        .offset_m = {0.1, 0.2, -0.3},
        .dofs = {Turn(Vector3d(1, 2, 2) / 3)}},
       {.name = "rail",
        .parent = 1,
        .offset_m = {0, 0.1, -0.4},
        .dofs = {Slide(Vector3d::UnitZ())}},
       {.name = "plate", .parent = 2, .offset_m = {0.1, 0, 0}},
       {.name = "ball",
        .parent = 0,
        .offset_m = {0, -0.2, 0.4},
        .dofs = {Turn(Vector3d::UnitX()), Turn(Vector3d::UnitZ()), Turn(Vector3d::UnitY())}}});
}

std::vector<LinkInertia> Links(int count) {
  std::vector<LinkInertia> links;
  for (int i = 0; i < count; ++i) {
    Eigen::Matrix3d root = Eigen::Matrix3d::Random();  // a fixed sequence
    links.push_back({.mass_kg = 1.0 + i,
                     .centre_m = 0.1 * Vector3d::Random(),
                     .inertia_kg_m2 = 0.05 * root * root.transpose()});
  }
  return links;
}

Eigen::RowVectorXd SmoothPose(const Skeleton& skeleton, double seconds) {
  Eigen::RowVectorXd pose(skeleton.dof_count());
  for (Eigen::Index c = 0; c < pose.size(); ++c) {
    const double i = static_cast<double>(c);
    pose[c] = 0.4 * std::sin((1 + 0.37 * i) * seconds + i);
  }
  return pose;
}

std::vector<Wrench> WrenchesAt(const Skeleton& skeleton, const std::vector<LinkInertia>& links,
                               double seconds) {
  const auto poses = [&](double at) {
    return ForwardKinematics(skeleton, SmoothPose(skeleton, at));
  };
  return LinkWrenches(links, poses(seconds - 1 / kRate), poses(seconds), poses(seconds + 1 / kRate),
                      kRate);
}

// Kinetic and potential energy by central differences of the links' poses.
double Energy(const Skeleton& skeleton, const std::vector<LinkInertia>& links, double seconds) {
  constexpr double kStep = 1e-4;
  const auto before = ForwardKinematics(skeleton, SmoothPose(skeleton, seconds - kStep));
  const auto at = ForwardKinematics(skeleton, SmoothPose(skeleton, seconds));
  const auto after = ForwardKinematics(skeleton, SmoothPose(skeleton, seconds + kStep));
  double energy = 0;
  for (std::size_t j = 0; j < links.size(); ++j) {
    const Vector3d velocity =
        (after[j] * links[j].centre_m - before[j] * links[j].centre_m) / (2 * kStep);
    const Eigen::AngleAxisd turn(
        Eigen::Matrix3d(before[j].linear().transpose() * after[j].linear()));
    const Vector3d spin = turn.angle() * turn.axis() / (2 * kStep);
    energy += links[j].mass_kg *
                  (velocity.squaredNorm() / 2 + kGravity * (at[j] * links[j].centre_m).z()) +
              spin.dot(links[j].inertia_kg_m2 * spin) / 2;
  }
  return energy;
}

TEST_CASE("JointEfforts: the power of all efforts is the change of energy", "[core][kinematics]") {
  const Skeleton skeleton = Robot();
  const std::vector<LinkInertia> links = Links(skeleton.joint_count());
  for (double seconds = 0.1; seconds < 3; seconds += 0.173) {
    const Eigen::RowVectorXd pose = SmoothPose(skeleton, seconds);
    const Eigen::RowVectorXd efforts = JointEfforts(
        skeleton, pose, ForwardKinematics(skeleton, pose), WrenchesAt(skeleton, links, seconds));
    const Eigen::RowVectorXd rates =
        (SmoothPose(skeleton, seconds + 1e-5) - SmoothPose(skeleton, seconds - 1e-5)) / 2e-5;
    const double change =
        (Energy(skeleton, links, seconds + 1e-3) - Energy(skeleton, links, seconds - 1e-3)) / 2e-3;
    CHECK(efforts.dot(rates) == Approx(change).epsilon(1e-3).margin(1e-2));
  }
}

TEST_CASE("JointEfforts: a still body's efforts are the slope of its potential energy",
          "[core][kinematics]") {
  const Skeleton skeleton = Robot();
  const std::vector<LinkInertia> links = Links(skeleton.joint_count());
  const Eigen::RowVectorXd pose = SmoothPose(skeleton, 0.6);
  const auto height = [&](const Eigen::RowVectorXd& at) {
    const auto poses = ForwardKinematics(skeleton, at);
    double sum = 0;
    for (std::size_t j = 0; j < links.size(); ++j) {
      sum += links[j].mass_kg * kGravity * (poses[j] * links[j].centre_m).z();
    }
    return sum;
  };
  const auto poses = ForwardKinematics(skeleton, pose);
  const Eigen::RowVectorXd efforts =
      JointEfforts(skeleton, pose, poses, LinkWrenches(links, poses, poses, poses, kRate));
  for (Eigen::Index c = 0; c < pose.size(); ++c) {
    Eigen::RowVectorXd above = pose;
    Eigen::RowVectorXd below = pose;
    above[c] += 1e-5;
    below[c] -= 1e-5;
    CHECK(efforts[c] == Approx((height(above) - height(below)) / 2e-5).margin(1e-6));
  }
}

TEST_CASE("JointEfforts: equations of a moving double pendulum", "[core][kinematics]") {
  constexpr double kUpper = 0.4;
  constexpr double kLower = 0.3;
  constexpr double kUpperMass = 2;
  constexpr double kLowerMass = 1.5;
  const Skeleton skeleton = DoublePendulum(kUpper);
  const std::vector<LinkInertia> links = {PointMass(kUpperMass, kUpper),
                                          PointMass(kLowerMass, kLower)};
  for (double s = 0; s < 2; s += 0.31) {
    const auto pose = [](double at) -> Eigen::RowVectorXd {
      return Eigen::RowVector2d(0.8 * std::sin(3 * at), 0.5 * std::cos(4 * at));
    };
    const double q2 = pose(s)[1];
    const double q1 = pose(s)[0];
    const double v1 = 2.4 * std::cos(3 * s);
    const double v2 = -2 * std::sin(4 * s);
    const double a1 = -7.2 * std::sin(3 * s);
    const double a2 = -8 * std::cos(4 * s);
    // Lagrange's equations of two point masses, angles from the vertical, the second relative.
    const double coupling = kLowerMass * kUpper * kLower;
    const double lower = kLowerMass * kLower * kLower * (a1 + a2) +
                         coupling * (a1 * std::cos(q2) + v1 * v1 * std::sin(q2)) +
                         kLowerMass * kGravity * kLower * std::sin(q1 + q2);
    const double upper =
        lower + (kUpperMass + kLowerMass) * kUpper * kUpper * a1 +
        coupling * ((a1 + a2) * std::cos(q2) - (v1 + v2) * (v1 + v2) * std::sin(q2)) +
        (kUpperMass + kLowerMass) * kGravity * kUpper * std::sin(q1);
    const auto poses = [&](double at) { return ForwardKinematics(skeleton, pose(at)); };
    const Eigen::RowVectorXd efforts = JointEfforts(
        skeleton, pose(s), poses(s),
        LinkWrenches(links, poses(s - 1 / kRate), poses(s), poses(s + 1 / kRate), kRate));
    CHECK(efforts[0] == Approx(upper).epsilon(1e-3).margin(1e-3));
    CHECK(efforts[1] == Approx(lower).epsilon(1e-3).margin(1e-3));
  }
}

TEST_CASE("JointEfforts: the floor's wrench leaves none to the base", "[core][kinematics]") {
  const Skeleton skeleton = Robot();
  std::vector<Wrench> wrenches = WrenchesAt(skeleton, Links(skeleton.joint_count()), 0.4);
  Wrench floor;
  for (const Wrench& wrench : wrenches) floor += wrench;
  wrenches[3] -= floor;
  const Eigen::RowVectorXd pose = SmoothPose(skeleton, 0.4);
  const Eigen::RowVectorXd efforts =
      JointEfforts(skeleton, pose, ForwardKinematics(skeleton, pose), wrenches);
  CHECK(efforts.head(6).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(std::abs(efforts[6]) > 1);
}

}  // namespace
}  // namespace motiondb::core::inverse_dynamics_test
