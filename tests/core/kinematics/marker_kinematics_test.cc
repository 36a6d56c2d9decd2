#include "core/kinematics/marker_kinematics.h"

#include "core/format/marker_set_file.h"
#include "tests/core/kinematics/figure.h"
#include "tests/support/real_data.h"
#include "tests/support/real_motion.h"

namespace motiondb::tests::marker_kinematics_test {
namespace {

using core::MarkerKinematics;
using core::MarkerPose;

// Returns the maximum difference between the Jacobian at a row of angles and central differences of
// the markers, m per unit of speed.
double JacobianError(const MarkerKinematics &kinematics, const Eigen::RowVectorXd &angles) {
  constexpr double kStep = 1e-5;
  MarkerPose pose = kinematics.NewPose();
  MarkerPose moved = kinematics.NewPose();
  pose.angles = angles;
  kinematics.Place(pose);
  kinematics.Differentiate(pose);
  double worst = 0;
  for (int c = 0; c < kinematics.dof_count(); ++c) {
    Eigen::Matrix3Xd analytic = Eigen::Matrix3Xd::Zero(3, kinematics.marker_count());
    for (int m = 0; m < kinematics.marker_count(); ++m) {
      const auto own = kinematics.Coordinates(m);
      const auto at = std::find(own.begin(), own.end(), c);
      if (at == own.end()) continue;
      analytic.col(m) = pose.jacobian.col(kinematics.first_column(m) + (at - own.begin()));
    }
    Eigen::VectorXd step = Eigen::VectorXd::Zero(kinematics.dof_count());
    step[c] = kStep;
    kinematics.Advance(pose, step, moved);
    kinematics.Place(moved);
    const Eigen::Matrix3Xd ahead = moved.markers_m;
    step[c] = -kStep;
    kinematics.Advance(pose, step, moved);
    kinematics.Place(moved);
    const Eigen::Matrix3Xd numeric = (ahead - moved.markers_m) / (2 * kStep);
    worst = std::max(worst, (analytic - numeric).cwiseAbs().maxCoeff());
  }
  return worst;
}

}  // namespace

TEST_CASE("MarkerKinematics: markers equal those of ApplyScheme", "[core][kinematics]") {
  const auto skeleton = Figure();
  const core::JointMotion motion = Swing(skeleton, 20);
  const auto leg_length_m = GENERATE(std::optional<double>(), std::optional<double>(0.7));
  const core::MarkerMotion expected = MarkersOf(FigureScheme(), motion, leg_length_m);
  // The legs are 0.8 m long in any pose, so the zero pose and the motion give the same length.
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton, leg_length_m);
  CHECK(kinematics.marker_names() == expected.names);
  MarkerPose pose = kinematics.NewPose();
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    pose.angles = motion.angles.row(frame);
    kinematics.Place(pose);
    for (int m = 0; m < kinematics.marker_count(); ++m) {
      const Eigen::Vector3d marker =
          expected.positions_m.row(frame).segment<3>(3 * m).transpose().cast<double>();
      CHECK((pose.markers_m.col(m) - marker).norm() < 1e-6);
    }
  }
}

TEST_CASE("MarkerKinematics: the Jacobian equals central differences", "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  CHECK(kinematics.TurnsFreely(skeleton->FindJoint("root")));
  CHECK(kinematics.TurnsFreely(skeleton->FindJoint("spine")));
  CHECK_FALSE(kinematics.TurnsFreely(skeleton->FindJoint("lhip")));
  const core::JointMotion motion = Swing(skeleton, 40, 10);
  for (int frame = 0; frame < 40; ++frame) {
    CHECK(JacobianError(kinematics, motion.angles.row(frame)) < 1e-8);
  }
  SECTION("also in gimbal lock of the root") {
    Eigen::RowVectorXd angles = motion.angles.row(0);
    angles[4] = M_PI / 2;
    CHECK(JacobianError(kinematics, angles) < 1e-8);
  }
}

TEST_CASE("MarkerKinematics: angles beyond full turns give the same pose", "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  const core::JointMotion motion = Swing(skeleton, 2, 4);
  MarkerPose pose = kinematics.NewPose();
  pose.angles = motion.angles.row(0);
  kinematics.Place(pose);
  const Eigen::Matrix3Xd markers = pose.markers_m;
  Eigen::RowVectorXd before = motion.angles.row(1);
  before[3] += 8 * M_PI;
  before[6] -= 6 * M_PI;
  kinematics.UnwrapAngles(before, pose);
  CHECK(std::abs(pose.angles[3] - before[3]) < M_PI);
  CHECK(std::abs(pose.angles[6] - before[6]) < M_PI);
  CHECK(core::CountLimitViolations({skeleton, 60, pose.angles}, 0) == 0);
  kinematics.Place(pose);
  CHECK((pose.markers_m - markers).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("SkeletonLegLength: hip to knee to ankle, independent of the root",
          "[core][kinematics]") {
  CHECK(core::SkeletonLegLength(FigureScheme(), Figure()).value() == Approx(0.8));
  CHECK(core::SkeletonLegLength(RobotScheme(), RobotLegs()).value() == Approx(0.8));
  CHECK(core::SkeletonLegLength(core::StandardScheme(), Figure()).status().code() ==
        absl::StatusCode::kInvalidArgument);
}

TEST_CASE("MarkerKinematics: refuses a skeleton without a matching mapping", "[core][kinematics]") {
  const auto made = MarkerKinematics::Create(core::StandardScheme(), Figure());
  REQUIRE_FALSE(made.ok());
  CHECK(made.status().code() == absl::StatusCode::kInvalidArgument);
}

TEST_CASE(
    "MarkerKinematics: the Jacobian of a CMU skeleton with the standard "
    "markers",
    "[core][kinematics][data]") {
  MOTIONDB_REQUIRE_DATA();
  const auto file = LoadMotion(DataDir() / "cmu/49/49_02.amc");
  const auto &motion = std::get<core::JointMotion>(file.motion);
  const MarkerKinematics kinematics = Kinematics(core::StandardScheme(), motion.skeleton);
  CHECK(kinematics.dof_count() == 62);
  CHECK(kinematics.TurnsFreely(0));
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); frame += 200) {
    CHECK(JacobianError(kinematics, motion.angles.row(frame)) < 1e-8);
  }
}

TEST_CASE("CountLimitViolations: counts degrees of freedom beyond a limit over all frames",
          "[core][kinematics]") {
  const auto skeleton = Figure();
  core::JointMotion motion = Swing(skeleton, 10);
  CHECK(core::CountLimitViolations(motion, 0) == 0);
  const int knee = skeleton->first_dof(skeleton->FindJoint("lknee"));
  motion.angles(2, knee) = 2.51;   // of 2.5
  motion.angles(3, knee) = 0.03;   // of 0.05
  motion.angles(3, knee + 1) = 7;  // of 1
  motion.angles(4, 0) = 1e9;       // the root has no limits
  CHECK(core::CountLimitViolations(motion, 0) == 3);
  CHECK(core::CountLimitViolations(motion, 0.015) == 2);
  CHECK(core::CountLimitViolations(motion, 0.1) == 1);
  SECTION("NaN is beyond limits") {
    motion.angles(9, 0) = std::nan("");
    CHECK(core::CountLimitViolations(motion, 0.1) == 2);
  }
}

}  // namespace motiondb::tests::marker_kinematics_test
