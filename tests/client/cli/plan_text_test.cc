#include "client/cli/plan_text.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "client/cli/terminal/terminal.h"
#include "tests/client/planned_motion.h"

namespace motiondb::tests::plan_text_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;
using Catch::StartsWith;

TEST_CASE("PlanText: outcome, segments, quality and effort", "[client][cli]") {
  CHECK(PlanText(QuarterCirclePlan()) ==
        R"(EXACT
plays 07_01 0.50-2.50 s
  distance from goal      m        0.021
  heading error           rad      0.012
  duration                s         2.00
  length                  m         1.57
  path correction         m        0.000
  path rotation           rad      0.000
  foot slide              cm/s      1.50
  floor penetration       cm        0.00
  peak marker jerk        m/s^3        0
  peak joint speed        rad/s     0.00
  peak joint jerk         rad/s^3      0
  joint limits exceeded                0
  marker fit error (rms)  m        0.000
  unlike stored motion                 -
  smallest clearance      m         0.42
searched 1234 states in 0.046 s, 1 improvement; 0.300 s including the motion; leg length 0.850 m
)");
}

TEST_CASE("PlanText: alternatives are columns beside the best", "[client][cli]") {
  v1::PlanResponse response = QuarterCirclePlan();
  v1::PlannedMotion& other = *response.add_alternatives();
  other = QuarterCircle(2);
  other.set_outcome(v1::PLAN_OUTCOME_APPROXIMATE);
  other.mutable_quality()->clear_smallest_clearance_m();
  const std::string text = WithStyles(PlanText(response), false);
  CHECK_THAT(text, Contains("BEST            2\n"));
  CHECK_THAT(text, Contains("outcome                          EXACT  APPROXIMATE\n"));
  CHECK_THAT(text, Contains("0.42            -\n"));
}

TEST_CASE("PlanText: what joint limits do, efforts and balance", "[client][cli]") {
  v1::PlanResponse response = QuarterCirclePlan();
  v1::PlannedMotion& motion = *response.mutable_motion();
  motion.mutable_quality()->set_stored_duration_seconds(1.5);
  motion.mutable_quality()->set_unknown_probability(0.31);
  motion.mutable_quality()->set_unknown_at_seconds(0.7);
  motion.mutable_quality()->set_joint_limit_violations(1);
  motion.mutable_quality()->set_joint_speed_violations(20);
  motion.mutable_quality()->set_joint_acceleration_violations(300);
  for (int i = 0; i < 5; ++i) {
    v1::SlowedPart& part = *motion.add_slowed_parts();
    part.set_start_seconds(i);
    part.set_end_seconds(i + 0.5);
    part.set_dof_name("knee" + std::to_string(i));
    part.set_limit(i == 1 ? v1::JOINT_LIMIT_ACCELERATION : v1::JOINT_LIMIT_SPEED);
    part.set_factor(3 - std::abs(i - 1));
    v1::JointEffort& effort = *motion.add_joint_efforts();
    effort.set_dof_name("ankle" + std::to_string(i));
    effort.set_peak_effort(10 * i);
    effort.set_at_seconds(0.25);
    if (i < 4) effort.set_effort_limit(20);
  }
  motion.mutable_balance()->set_smallest_margin_m(-0.04);
  motion.mutable_balance()->set_at_seconds(1.25);
  motion.mutable_balance()->set_outside_seconds(0.5);
  motion.mutable_balance()->set_supported_seconds(2);
  CHECK_THAT(PlanText(response), Contains("unlike stored motion             0.31 at 0.70 s\n"));
  CHECK_THAT(PlanText(response), Contains(R"(
slowed by joint limits from 1.50 s to 2.00 s
  3.00 times at 1.00-1.50 s by the acceleration of knee1
  2.00 times at 0.00-0.50 s by the speed of knee0
  2.00 times at 2.00-2.50 s by the speed of knee2
  less in 2 more parts
ankle3 needs an effort of 30 at 0.25 s, limit 20
ankle2 needs an effort of 20 at 0.25 s, limit 20
ankle1 needs an effort of 10 at 0.25 s, limit 20
zero-moment point 0.040 m outside the soles at 1.25 s, outside for 0.50 of 2.00 s
)"));
  CHECK_THAT(PlanText(response), Contains("joint limits exceeded                       321\n"));
}

TEST_CASE("PlanText: reports why a goal is unreachable", "[client][cli]") {
  v1::PlanResponse response;
  response.set_outcome(v1::PLAN_OUTCOME_UNREACHABLE);
  response.set_missing("too far");
  CHECK_THAT(PlanText(response), StartsWith("UNREACHABLE: too far\nsearched 0 states"));
  CHECK(OutcomeText(static_cast<v1::PlanOutcome>(77)) == "outcome 77");
}

TEST_CASE("PlanText: lists only the first of many segments", "[client][cli]") {
  v1::PlanResponse response = QuarterCirclePlan();
  for (int i = 0; i < 9; ++i) {
    response.mutable_motion()->add_segments()->set_clip("databases/walks/clips/b");
  }
  CHECK_THAT(PlanText(response), Contains("b 0.00-0.00 s and 2 more\n"));
}

}  // namespace
}  // namespace motiondb::tests::plan_text_test
