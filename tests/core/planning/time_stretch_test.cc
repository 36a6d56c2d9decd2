#include "core/planning/time_stretch.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/motion/forward_kinematics.h"
#include "core/planning/plan.h"
#include "tests/core/planning/flat_footed_robot.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::time_stretch_test {
namespace {

constexpr double kRate = 60;
constexpr double kNone = std::numeric_limits<double>::infinity();

MarkerKinematics Kinematics() {
  auto kinematics = MarkerKinematics::Create(tests::RobotScheme(), tests::FlatFootedRobot());
  INFO(kinematics.status());
  REQUIRE(kinematics.ok());
  return *std::move(kinematics);
}

// Smooth random angles within the limits, with a jump of all joints. The base turns through gimbal
// lock.
JointMotion Wild(std::uint32_t seed, int frames) {
  std::mt19937 random(seed);
  const auto number = [&] { return static_cast<double>(random()) / std::mt19937::max(); };
  const auto skeleton = tests::FlatFootedRobot();
  const JointLimits limits = LimitsOf(*skeleton);
  JointMotion motion{skeleton, kRate, JointMatrix(frames, skeleton->dof_count())};
  const int jump = static_cast<int>(random() % static_cast<unsigned>(frames));
  for (Eigen::Index c = 0; c < motion.angles.cols(); ++c) {
    const double lower = std::max(limits.lower[c], -2.0);
    const double upper = std::min(limits.upper[c], 2.0);
    const double pace = 0.05 + 0.3 * number();
    const double phase = 6 * number();
    for (int t = 0; t < frames; ++t) {
      const double swing = std::sin(pace * t + phase + (t > jump ? 1.0 : 0.0));
      motion.angles(t, c) = (lower + upper) / 2 + 0.5 * (upper - lower) * swing;
    }
  }
  return motion;
}

RobotDynamics Speeds(double speed) {
  RobotDynamics dynamics;
  dynamics.max_speeds = Eigen::RowVectorXd::Constant(tests::FlatFootedRobot()->dof_count(), speed);
  return dynamics;
}

// Largest first and second difference of the joints' angles as a user computes it.
std::pair<double, double> LargestRates(const JointMotion& motion) {
  const auto q = motion.angles.rightCols(motion.angles.cols() - 6);
  const Eigen::Index last = q.rows() - 1;
  const JointMatrix steps = q.bottomRows(last) - q.topRows(last);
  const JointMatrix changes = steps.bottomRows(last - 1) - steps.topRows(last - 1);
  return {steps.cwiseAbs().maxCoeff() * motion.frame_rate_hz,
          changes.cwiseAbs().maxCoeff() * motion.frame_rate_hz * motion.frame_rate_hz};
}

TEST_CASE("StretchTime: samples of wild motions respect all limits at every rate",
          "[core][planning]") {
  const MarkerKinematics kinematics = Kinematics();
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const JointMotion wild = Wild(seed, 80);
    const double speed = 1.0 + seed % 4;
    const double acceleration = 8.0 + 10 * (seed % 3);
    const RobotDynamics dynamics = Speeds(2 * speed);
    const RateLimits limits = LimitRates(*wild.skeleton, &dynamics, 0.5, acceleration);
    REQUIRE(CountRateViolations(kinematics, wild, limits).speeds > 0);
    for (const double rate : {25.0, 60.0, 144.0}) {
      CAPTURE(seed, rate);
      const StretchedMotion stretched = StretchTime(kinematics, wild, limits, rate, 1000);
      const auto [fastest, strongest] = LargestRates(stretched.motion);
      CHECK(fastest <= speed);
      CHECK(fastest >= 0.3 * speed);  // not slower than needed by much
      CHECK(strongest <= acceleration);
      const RateViolations violations = CountRateViolations(kinematics, stretched.motion, limits);
      CHECK(violations.speeds == 0);
      CHECK(violations.accelerations == 0);
      CHECK(CountLimitViolations(stretched.motion, 0) == 0);
      CHECK_FALSE(stretched.cut);
      // All poses in order, from the first to the last.
      CHECK(std::is_sorted(stretched.places.begin(), stretched.places.end()));
      CHECK(stretched.places.front() == 0);
      CHECK(stretched.places.back() == Approx(79));
      CHECK(stretched.motion.angles.row(0).isApprox(wild.angles.row(0), 1e-9));
      const auto poses = ForwardKinematics(*wild.skeleton, wild.angles.row(79));
      const auto ends = ForwardKinematics(
          *wild.skeleton, stretched.motion.angles.row(stretched.motion.angles.rows() - 1));
      for (std::size_t j = 0; j < poses.size(); ++j) CHECK(ends[j].isApprox(poses[j], 1e-6));
      CHECK_FALSE(stretched.slowed.empty());
    }
  }
}

TEST_CASE("StretchTime: a motion within the limits is returned unchanged", "[core][planning]") {
  const MarkerKinematics kinematics = Kinematics();
  const JointMotion wild = Wild(1, 50);
  const RobotDynamics dynamics = Speeds(1000);
  const auto stretched =
      StretchTime(kinematics, wild, LimitRates(*wild.skeleton, &dynamics, 1, 0), kRate, 1000);
  CHECK(stretched.motion.angles == wild.angles);
  CHECK(stretched.slowed.empty());
  CHECK(stretched.places.size() == 50);
}

TEST_CASE("StretchTime: what does not move stays still", "[core][planning]") {
  const MarkerKinematics kinematics = Kinematics();
  JointMotion motion = Wild(3, 60);
  const int knee = motion.skeleton->first_dof(motion.skeleton->FindJoint("left_knee"));
  motion.angles.middleRows(20, 20).rowwise() = motion.angles.row(20);
  motion.angles.col(knee).setConstant(0.7);
  const RobotDynamics dynamics = Speeds(1);
  const auto stretched =
      StretchTime(kinematics, motion, LimitRates(*motion.skeleton, &dynamics, 1, 20), kRate, 1000);
  CHECK((stretched.motion.angles.col(knee).array() - 0.7).abs().maxCoeff() < 1e-12);
  for (std::size_t t = 0; t < stretched.places.size(); ++t) {
    if (stretched.places[t] < 21 || stretched.places[t] > 38) continue;
    CHECK(
        stretched.motion.angles.row(static_cast<Eigen::Index>(t)).isApprox(motion.angles.row(20)));
  }
}

TEST_CASE("StretchTime: a motion that needs too long is cut", "[core][planning]") {
  const MarkerKinematics kinematics = Kinematics();
  const JointMotion wild = Wild(4, 60);
  const RobotDynamics dynamics = Speeds(0.001);
  const auto stretched =
      StretchTime(kinematics, wild, LimitRates(*wild.skeleton, &dynamics, 1, 0), kRate, 2);
  CHECK(stretched.cut);
  CHECK(stretched.motion.angles.rows() == 121);
  CHECK(stretched.needed_seconds > 100);
  for (const SlowedPart& part : stretched.slowed) CHECK(part.start_seconds < 2);
}

TEST_CASE("JointPath: the base passes gimbal lock at a constant speed", "[core][planning]") {
  const MarkerKinematics kinematics = Kinematics();
  const auto skeleton = tests::FlatFootedRobot();
  const Eigen::Vector3d axis = Eigen::Vector3d(0.1, 1, 0.02).normalized();
  const std::array<Eigen::Vector3d, 3> axes = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                                               Eigen::Vector3d::UnitX()};
  JointMatrix poses = JointMatrix::Zero(40, skeleton->dof_count());
  Eigen::Vector3d angles = Eigen::Vector3d::Zero();
  for (int t = 0; t < 40; ++t) {
    angles = AnglesAboutAxes(Eigen::AngleAxisd(0.1 * t, axis).toRotationMatrix(), axes, angles);
    poses.row(t).segment<3>(3) = angles.transpose();
  }
  const JointPath path(kinematics, poses);
  Eigen::RowVectorXd pose = poses.row(0);
  for (double place = 0; place <= 39; place += 0.25) {
    pose = path.At(place, pose);
    const Eigen::Matrix3d turn = ForwardKinematics(*skeleton, pose)[0].linear();
    CHECK(turn.isApprox(Eigen::AngleAxisd(0.1 * place, axis).toRotationMatrix(), 1e-6));
  }
}

TEST_CASE("LimitRates: the root has no limits; the scale applies to speeds", "[core][planning]") {
  const auto skeleton = tests::FlatFootedRobot();
  const RobotDynamics dynamics = Speeds(4);
  const RateLimits limits = LimitRates(*skeleton, &dynamics, 0.25, 7);
  for (int c = 0; c < skeleton->dof_count(); ++c) {
    CHECK(limits.speed[c] == (c < 6 ? kNone : 1));
    CHECK(limits.acceleration[c] == (c < 6 ? kNone : 7));
  }
  CHECK_FALSE(AnyLimit(LimitRates(*skeleton, nullptr, 1, 0)));
  CHECK(AnyLimit(limits));
}

PlanProblem RobotProblem() {
  PlanProblem problem;
  problem.start.clip = ClipMoment{"straight", 0.2};
  problem.goal = {1.2, 0.3, 0.4};
  problem.skeleton = tests::FlatFootedRobot();
  problem.flat_soles = true;
  return problem;
}

PlanAnswer Solve(const PlanProblem& problem) {
  auto answer = PlanMotion(tests::WalkingDatabase(), tests::RobotScheme(), problem);
  INFO(answer.status());
  REQUIRE(answer.ok());
  REQUIRE_FALSE(answer->motions.empty());
  return *std::move(answer);
}

TEST_CASE("Plan: a robot arrives on the same path, as fast as its limits allow",
          "[core][planning]") {
  PlanProblem problem = RobotProblem();
  const PlannedMotion recorded = Solve(problem).motions.front();
  problem.dynamics = std::make_shared<RobotDynamics>(Speeds(3));
  problem.max_joint_acceleration = 30;
  const PlanAnswer answer = Solve(problem);
  CHECK(answer.outcome == PlanOutcome::kExact);
  const PlannedMotion& planned = answer.motions.front();
  const auto [fastest, strongest] = LargestRates(*planned.joints);
  CHECK(LargestRates(*recorded.joints).first > 3);
  CHECK(fastest <= 3);
  CHECK(strongest <= 30);
  CHECK(planned.quality.rate_violations.speeds == 0);
  CHECK(planned.quality.recorded_seconds == Approx(recorded.quality.duration_seconds));
  CHECK(planned.quality.duration_seconds > 1.1 * recorded.quality.duration_seconds);
  CHECK(planned.quality.length_m == Approx(recorded.quality.length_m).epsilon(0.02));
  CHECK(planned.quality.motion.foot_slide_cm_per_s <= recorded.quality.motion.foot_slide_cm_per_s);
  CHECK(planned.contacts.rows() == planned.root.rows());
  REQUIRE_FALSE(planned.slowed.empty());

  // Half the speed is scaled from the limits.
  problem.max_joint_acceleration.reset();
  problem.speed_limit_scale = 0.5;
  CHECK(LargestRates(*Solve(problem).motions.front().joints).first <= 1.5);

  // Without limits of joints, violations are counted.
  problem.respect_joint_limits = false;
  const PlannedMotion ignored = Solve(problem).motions.front();
  CHECK(ignored.slowed.empty());
  CHECK(ignored.quality.rate_violations.speeds > 0);
}

TEST_CASE("Plan: limits that need more than the maximum duration make it approximate",
          "[core][planning]") {
  PlanProblem problem = RobotProblem();
  problem.dynamics = std::make_shared<RobotDynamics>(Speeds(0.05));
  problem.max_duration_seconds = 6;
  const PlanAnswer answer = Solve(problem);
  CHECK(answer.outcome == PlanOutcome::kApproximate);
  CHECK_THAT(answer.missing, Catch::Contains("within the joint limits, expected at most 6"));
  CHECK(answer.motions.front().quality.duration_seconds == Approx(6));
}

TEST_CASE("Plan: an acceleration limit needs joints", "[core][planning]") {
  PlanProblem problem = RobotProblem();
  problem.skeleton = nullptr;
  problem.max_joint_acceleration = 10;
  const auto answer = PlanMotion(tests::WalkingDatabase(), tests::RobotScheme(), problem);
  CHECK_THAT(std::string(answer.status().message()), Catch::StartsWith("max_joint_acceleration: "));
}

}  // namespace
}  // namespace motiondb::core::time_stretch_test
