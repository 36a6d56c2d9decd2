#include <catch2/catch.hpp>

#include "client/cli/answer_text.h"
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
  const std::string text = PlanText(response);
  CHECK_THAT(text, Contains("BEST            2\n"));
  CHECK_THAT(text, Contains("outcome                          EXACT  APPROXIMATE\n"));
  CHECK_THAT(text, Contains("0.42            -\n"));
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
