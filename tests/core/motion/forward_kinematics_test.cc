#include "core/motion/forward_kinematics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace motiondb::tests::forward_kinematics_test {
namespace {

using core::Dof;
using core::Joint;
using core::Skeleton;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::RowVectorXd;
using Eigen::Vector3d;

constexpr double kRightAngle = std::numbers::pi / 2;

Dof Rotation(const Vector3d& axis) { return {.kind = Dof::Kind::kRotation, .axis = axis}; }
Dof Translation(const Vector3d& axis) { return {.kind = Dof::Kind::kTranslation, .axis = axis}; }

Skeleton Make(std::vector<Joint> joints) {
  auto skeleton = Skeleton::Create("test", std::move(joints));
  REQUIRE(skeleton.ok());
  return *std::move(skeleton);
}

RowVectorXd Row(std::initializer_list<double> values) {
  RowVectorXd row(values.size());
  std::copy(values.begin(), values.end(), row.data());
  return row;
}

bool Near(const Vector3d& a, const Vector3d& b) { return (a - b).norm() < 1e-12; }

// Shoulder at the origin, elbow at 1 m and hand at 1.5 m along x; both rotate about z.
Skeleton TwoLinkArm() {
  return Make({{.name = "shoulder", .dofs = {Rotation(Vector3d::UnitZ())}},
               {.name = "elbow",
                .parent = 0,
                .offset_m = Vector3d(1, 0, 0),
                .dofs = {Rotation(Vector3d::UnitZ())}},
               {.name = "hand", .parent = 1, .offset_m = Vector3d(0.5, 0, 0), .dofs = {}}});
}

}  // namespace

TEST_CASE("ForwardKinematics: a subset of joints has the same poses", "[core][motion]") {
  const Skeleton arm = TwoLinkArm();
  const RowVectorXd angles = Row({0.3, -0.7});
  const auto all = core::ForwardKinematics(arm, angles);
  std::vector<Eigen::Isometry3d> subset(3, Eigen::Isometry3d::Identity());
  core::ForwardKinematics(arm, angles, std::vector<int>{0, 1}, subset);
  CHECK(subset[0].matrix() == all[0].matrix());
  CHECK(subset[1].matrix() == all[1].matrix());
  CHECK(subset[2].matrix() == Eigen::Isometry3d::Identity().matrix());
}

TEST_CASE("ForwardKinematics: a two-link arm", "[core][motion]") {
  const Skeleton arm = TwoLinkArm();
  SECTION("straight") {
    const auto pose = core::ForwardKinematics(arm, Row({0, 0}));
    CHECK(Near(pose[1].translation(), {1, 0, 0}));
    CHECK(Near(pose[2].translation(), {1.5, 0, 0}));
  }
  SECTION("shoulder and elbow at right angles") {
    const auto pose = core::ForwardKinematics(arm, Row({kRightAngle, kRightAngle}));
    CHECK(Near(pose[1].translation(), {0, 1, 0}));
    CHECK(Near(pose[2].translation(), {-0.5, 1, 0}));
    CHECK(Near(pose[2].linear() * Vector3d::UnitX(), {-1, 0, 0}));
  }
}

TEST_CASE("ForwardKinematics: rotations apply leftmost first", "[core][motion]") {
  // R = Rz Rx: Rx takes y to z, and Rz keeps z.
  const Skeleton zx =
      Make({{.name = "a", .dofs = {Rotation(Vector3d::UnitZ()), Rotation(Vector3d::UnitX())}}});
  const auto pose = core::ForwardKinematics(zx, Row({kRightAngle, kRightAngle}));
  CHECK(Near(pose[0].linear() * Vector3d::UnitY(), Vector3d::UnitZ()));
  // R = Rx Rz: Rz takes y to -x, and Rx keeps it.
  const Skeleton xz =
      Make({{.name = "a", .dofs = {Rotation(Vector3d::UnitX()), Rotation(Vector3d::UnitZ())}}});
  const auto other = core::ForwardKinematics(xz, Row({kRightAngle, kRightAngle}));
  CHECK(Near(other[0].linear() * Vector3d::UnitY(), -Vector3d::UnitX()));
}

TEST_CASE("ForwardKinematics: translations add to the offset in the parent's frame",
          "[core][motion]") {
  const Skeleton slider =
      Make({{.name = "root",
             .offset_m = Vector3d(0, 0, 1),
             .dofs = {Translation(Vector3d::UnitX()), Translation(Vector3d::UnitZ()),
                      Rotation(Vector3d::UnitZ())}},
            {.name = "slide",
             .parent = 0,
             .offset_m = Vector3d(2, 0, 0),
             .dofs = {Translation(Vector3d::UnitY())}}});
  const auto pose = core::ForwardKinematics(slider, Row({3, -1, kRightAngle, 0.5}));
  CHECK(Near(pose[0].translation(), {3, 0, 0}));
  CHECK(Near(pose[1].translation(), {2.5, 2, 0}));
}

TEST_CASE("ForwardKinematics: a bone with its own axes, as in ASF", "[core][motion]") {
  // The bone's axes are the parent's, rotated by 90 degrees about z: its x is the parent's y.
  const Matrix3d c = AngleAxisd(kRightAngle, Vector3d::UnitZ()).toRotationMatrix();
  const Skeleton bone =
      Make({{.name = "bone",
             .pre_rotation = c,
             .post_rotation = c.transpose(),
             .dofs = {Rotation(Vector3d::UnitX())}},
            {.name = "tip", .parent = 0, .offset_m = Vector3d(1, 0, 0), .dofs = {}}});
  CHECK(Near(core::ForwardKinematics(bone, Row({0}))[1].translation(), {1, 0, 0}));
  // A rotation by 90 degrees about the parent's y takes x to -z.
  CHECK(Near(core::ForwardKinematics(bone, Row({kRightAngle}))[1].translation(), {0, 0, -1}));
}

TEST_CASE("JointPositions: every frame equals its own forward kinematics", "[core][motion]") {
  core::JointMotion motion{.skeleton = std::make_shared<Skeleton>(TwoLinkArm()),
                           .frame_rate_hz = 10,
                           .angles = core::JointMatrix(5, 2)};
  for (int f = 0; f < 5; ++f) motion.angles.row(f) << 0.3 * f, 1.0 - 0.7 * f;
  const core::FrameMatrix positions = core::JointPositions(motion);
  REQUIRE(positions.rows() == 5);
  REQUIRE(positions.cols() == 9);
  for (int f = 0; f < 5; ++f) {
    const double a = 0.3 * f;
    const double b = a + 1.0 - 0.7 * f;
    CHECK(positions(f, 6) == Approx(std::cos(a) + 0.5 * std::cos(b)).margin(1e-6));
    CHECK(positions(f, 7) == Approx(std::sin(a) + 0.5 * std::sin(b)).margin(1e-6));
    CHECK(positions(f, 8) == Approx(0).margin(1e-6));
  }
}

TEST_CASE("JointRotations: unit quaternions without jumps", "[core][motion]") {
  core::JointMotion motion{.skeleton = std::make_shared<Skeleton>(TwoLinkArm()),
                           .frame_rate_hz = 10,
                           .angles = core::JointMatrix(60, 2)};
  // The shoulder makes more than two turns; the elbow holds 45 degrees.
  for (int f = 0; f < 60; ++f) motion.angles.row(f) << 0.25 * f, kRightAngle / 2;
  const core::FrameMatrix rotations = core::JointRotations(motion);
  REQUIRE(rotations.rows() == 60);
  REQUIRE(rotations.cols() == 12);
  for (int f = 0; f < 60; ++f) {
    for (int joint = 0; joint < 3; ++joint) {
      // About z by a: (0, 0, sin(a / 2), cos(a / 2)), which is continuous in a.
      const double half = (0.25 * f + (joint > 0 ? kRightAngle / 2 : 0)) / 2;
      const Eigen::RowVector4f expected(0, 0, static_cast<float>(std::sin(half)),
                                        static_cast<float>(std::cos(half)));
      CHECK((rotations.block<1, 4>(f, 4 * joint) - expected).norm() < 1e-6F);
    }
  }
}

}  // namespace motiondb::tests::forward_kinematics_test
