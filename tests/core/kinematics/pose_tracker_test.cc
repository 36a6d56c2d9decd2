#include <limits>

#include "core/kinematics/inverse_kinematics.h"
#include "tests/core/kinematics/figure.h"

namespace motiondb::tests::pose_tracker_test {
namespace {

using core::MarkerKinematics;
using core::MarkerMotion;
using core::PoseTracker;

// Returns the fraction of frames that are found to 1 mm, each without a previous frame.
double FractionFound(const core::MarkerScheme& scheme, const core::JointMotion& poses) {
  const MarkerKinematics kinematics = Kinematics(scheme, poses.skeleton);
  const MarkerMotion markers = MarkersOf(scheme, poses);
  int found = 0;
  for (Eigen::Index frame = 0; frame < poses.angles.rows(); ++frame) {
    PoseTracker tracker(kinematics, {});
    found += tracker.Follow(markers.positions_m.row(frame)).largest_m < 1e-3;
  }
  return static_cast<double>(found) / static_cast<double>(poses.angles.rows());
}

}  // namespace

TEST_CASE("PoseTracker: finds random poses without a previous pose", "[core][kinematics]") {
  SECTION("of a figure") {
    const double reach = GENERATE(0.6, 1.2);
    CHECK(FractionFound(FigureScheme(), RandomPoses(Figure(), 200, reach)) >= 0.98);
  }
  SECTION("of a robot's legs") {
    CHECK(FractionFound(RobotScheme(), RandomPoses(RobotLegs(), 200, 3)) >= 0.95);
  }
}

TEST_CASE("PoseTracker: a robot that squats straight down from straight legs",
          "[core][kinematics]") {
  // Hips, knees and ankles in one line: the first step does not determine the direction in which
  // the knees bend.
  const auto skeleton = RobotLegs();
  core::JointMotion motion{skeleton, 60, core::JointMatrix::Zero(101, skeleton->dof_count())};
  const auto column = [&](const std::string& joint) {
    return skeleton->first_dof(skeleton->FindJoint(joint));
  };
  for (int frame = 0; frame <= 100; ++frame) {
    const double bend = 0.008 * frame;
    motion.angles(frame, 2) = 0.8 * std::cos(bend);
    for (const std::string s : {"l", "r"}) {
      motion.angles(frame, column(s + "hip_pitch")) = -bend;
      motion.angles(frame, column(s + "knee")) = 2 * bend;
      motion.angles(frame, column(s + "ankle")) = -bend;
    }
  }
  const MarkerMotion markers = MarkersOf(RobotScheme(), motion);
  const MarkerKinematics kinematics = Kinematics(RobotScheme(), skeleton);
  PoseTracker tracker(kinematics, {});
  for (int frame = 0; frame <= 100; ++frame) {
    CHECK(tracker.Follow(markers.positions_m.row(frame)).largest_m < 1e-3);
  }
  CHECK(tracker.pose().angles[column("lknee")] == Approx(1.6).margin(1e-2));
}

TEST_CASE("PoseTracker: a frame without markers keeps the pose", "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  const MarkerMotion markers = MarkersOf(FigureScheme(), Swing(skeleton, 2));
  const Eigen::RowVectorXf none = Eigen::RowVectorXf::Constant(
      markers.positions_m.cols(), std::numeric_limits<float>::quiet_NaN());
  PoseTracker tracker(kinematics, {});
  tracker.Follow(none);
  CHECK_FALSE(tracker.has_begun());
  tracker.Follow(markers.positions_m.row(0));
  CHECK(tracker.has_begun());
  const Eigen::RowVectorXd angles = tracker.pose().angles;
  CHECK(tracker.Follow(none).rms_m == 0);
  CHECK(tracker.pose().angles == angles);
}

TEST_CASE("PoseTracker: a cut in the motion restarts the search", "[core][kinematics]") {
  const auto skeleton = Figure();
  const MarkerKinematics kinematics = Kinematics(FigureScheme(), skeleton);
  const MarkerMotion markers = MarkersOf(FigureScheme(), RandomPoses(skeleton, 60, 1.2));
  PoseTracker tracker(kinematics, {});
  int found = 0;
  double largest_turn = 0;
  for (int pose = 0; pose < 60; ++pose) {
    const Eigen::RowVectorXd before = tracker.pose().angles;
    tracker.Follow(markers.positions_m.row(pose));
    if (pose > 0) {
      largest_turn = std::max(largest_turn, (tracker.pose().angles - before).cwiseAbs().maxCoeff());
    }
    tracker.Follow(markers.positions_m.row(pose));
    found += tracker.Follow(markers.positions_m.row(pose)).largest_m < 1e-3;
  }
  CHECK(found >= 57);
  CHECK(largest_turn <= 4);  // a hip between its limits; half a turn without limits
}

}  // namespace motiondb::tests::pose_tracker_test
