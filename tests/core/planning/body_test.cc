#include "core/planning/body.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/kinematics/marker_kinematics.h"
#include "core/planning/goal.h"
#include "core/planning/plan.h"
#include "tests/core/planning/flat_footed_robot.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::body_test {
namespace {

using tests::WalkerIndex;
using tests::WalkingDatabase;

Body Robot() {
  auto body =
      Body::OfSkeleton(WalkingDatabase(), tests::RobotScheme(), tests::FlatFootedRobot(), true);
  INFO(body.status());
  REQUIRE(body.ok());
  return *std::move(body);
}

Eigen::Vector3f At(const FrameMatrix& positions, Eigen::Index t, int marker) {
  return positions.row(t).segment<3>(3 * marker).transpose();
}

TEST_CASE("Body: a robot has its own size and soles", "[planning]") {
  const Body robot = Robot();
  CHECK(robot.leg_length_m() == Approx(tests::kRobotLeg_m));
  for (const Foot& foot : robot.feet()) {
    for (const float height : foot.rest_heights) CHECK(height == 0);
  }
  for (const Foot& foot : robot.stored_feet()) {
    for (const float height : foot.rest_heights) CHECK(height > 0.02F);
  }
}

TEST_CASE("Body: markers without a skeleton are unchanged", "[planning]") {
  const Body body = Body::OfSize(WalkingDatabase(), 0.5);
  FrameMatrix positions = tests::WalkingFigure{}.Motion().positions_m;
  const FrameMatrix before = positions;
  body.Fit(positions);
  CHECK(positions == before);
}

TEST_CASE("Body: on soles, feet keep their direction and stand on the floor", "[planning]") {
  const Body robot = Robot();
  tests::WalkingFigure figure;
  FrameMatrix positions = figure.Motion().positions_m;
  positions *= static_cast<float>(tests::kRobotLeg_m / tests::WalkingFigure::kLeg_m);
  const FrameMatrix before = positions;
  robot.Fit(positions);
  int standing = 0;
  for (Eigen::Index t = 0; t < positions.rows(); ++t) {
    for (const int side : {0, 1}) {
      const auto heading = [&](const FrameMatrix& p) {
        const Eigen::Vector3f along =
            At(p, t, WalkerIndex(side, tests::kToe)) - At(p, t, WalkerIndex(side, tests::kHeel));
        return std::atan2(along.y(), along.x());
      };
      CHECK(heading(positions) == Approx(heading(before)).margin(0.02));
      const double seconds = static_cast<double>(t) / figure.rate_hz;
      if (!figure.Stands(side, tests::kHeel, seconds) ||
          !figure.Stands(side, tests::kToe, seconds)) {
        continue;
      }
      ++standing;
      for (const auto marker : {tests::kHeel, tests::kToe}) {
        CHECK(std::abs(At(positions, t, WalkerIndex(side, marker)).z()) < 0.006F);
      }
      const float ankle = At(positions, t, WalkerIndex(side, tests::kAnkle)).z();
      CHECK(ankle == Approx(tests::kRobotAnkle_m).margin(0.006));
    }
  }
  CHECK(standing > 100);
}

TEST_CASE("Plan: a robot arrives within its joint limits, with its feet on the floor",
          "[planning]") {
  PlanProblem problem;
  problem.start.clip = ClipMoment{"straight", 0.2};
  problem.goal = {1.2, 0.3, 0.4};
  problem.skeleton = tests::FlatFootedRobot();
  problem.flat_soles = true;
  const auto answer = PlanMotion(WalkingDatabase(), tests::RobotScheme(), problem);
  INFO(answer.status());
  REQUIRE(answer.ok());
  INFO(answer->missing);
  REQUIRE(answer->outcome == PlanOutcome::kExact);
  const PlannedMotion& motion = answer->motions.front();
  REQUIRE(motion.joints.has_value());
  CHECK(CountLimitViolations(*motion.joints, 1e-9) == 0);
  CHECK(motion.quality.joint_limit_violations == 0);
  const auto markers = ApplyScheme(tests::RobotScheme(), *motion.joints, answer->leg_length_m);
  REQUIRE(markers.ok());
  CHECK(markers->positions_m == motion.markers.positions_m);
  CHECK(motion.quality.motion.floor_penetration_cm < 1.5);
  CHECK(motion.quality.motion.foot_slide_cm_per_s < 8);
}

// Its pelvis hardly turns against the feet, so that it ends beside the heading of its markers by
// more than a correction covers.
TEST_CASE("Plan: a body that ends beside its path arrives on another path", "[planning]") {
  PlanProblem problem;
  problem.start.clip = ClipMoment{"straight", 0.2};
  problem.skeleton = tests::FlatFootedRobot(0.02);
  problem.flat_soles = true;
  int exact = 0;
  for (const double distance : {0.8, 1.1, 1.5}) {
    for (const double bearing : {-0.6, -0.3, 0.0, 0.3, 0.6}) {
      for (const double turn : {-0.3, 0.3}) {
        problem.goal = {distance * std::cos(bearing), distance * std::sin(bearing), bearing + turn};
        const auto answer = PlanMotion(WalkingDatabase(), tests::RobotScheme(), problem);
        REQUIRE(answer.ok());
        REQUIRE(answer->motions.size() == 1);
        const PlanQuality& quality = answer->motions.front().quality;
        CHECK(quality.correction_m <= kMaxCorrection * quality.length_m * 1.05);
        exact += answer->outcome == PlanOutcome::kExact;
      }
    }
  }
  CHECK(exact >= 27);  // of 30; with one search: 23
}

TEST_CASE("Plan: a skeleton without the scheme's markers is refused", "[planning]") {
  PlanProblem problem;
  problem.goal = {1, 0, 0};
  problem.skeleton = tests::FlatFootedRobot();
  const auto answer = PlanMotion(WalkingDatabase(), tests::WalkerScheme(), problem);
  CHECK(answer.status().code() == absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace motiondb::core::body_test
