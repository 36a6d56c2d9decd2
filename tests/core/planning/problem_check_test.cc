#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/plan.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::core::problem_check_test {
namespace {

const double kNan = std::nan("");
constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Model& TwoClips() {
  static const Model model = tests::SmallModel(2, 40, 4, 8, 1);
  return model;
}

PlanProblem GoodProblem() {
  PlanProblem problem;
  problem.obstacles.discs = {{{2, -1}, 0.5}};
  problem.obstacles.polygons = {{{{0, 0}, {1, 0}, {0, 1}}}};
  return problem;
}

// Returns the field that is refused after `change`; empty if none.
template <typename Change>
std::string RefusedAfter(Change change) {
  PlanProblem problem = GoodProblem();
  change(problem);
  const absl::Status status = CheckProblem(TwoClips(), problem);
  if (status.ok()) return "";
  CHECK(absl::IsInvalidArgument(status));
  const auto field = status.GetPayload(kFieldUrl);
  REQUIRE(field.has_value());
  CHECK_THAT(std::string(status.message()), Catch::StartsWith(std::string(*field) + ": "));
  return std::string(*field);
}

TEST_CASE("CheckProblem: a valid problem is accepted", "[core][planning]") {
  CHECK(RefusedAfter([](PlanProblem&) {}).empty());
  CHECK(RefusedAfter([](PlanProblem& p) { p.obstacles = {}; }).empty());
  CHECK(RefusedAfter([](PlanProblem& p) { p.obstacles.clearance_m = 0; }).empty());
  CHECK(RefusedAfter([](PlanProblem& p) {
          p.playable.labels = {TwoClips().clips()[0].label()};
        }).empty());
}

TEST_CASE("CheckProblem: each wrong number is named", "[core][planning]") {
  for (const double bad : {kNan, kInfinity, -kInfinity, 1001.0}) {
    CHECK(RefusedAfter([&](PlanProblem& p) { p.goal.x = bad; }) == "goal.x_m");
    CHECK(RefusedAfter([&](PlanProblem& p) { p.goal.y = bad; }) == "goal.y_m");
  }
  for (const double bad : {kNan, 6.3, -90.0}) {
    CHECK(RefusedAfter([&](PlanProblem& p) { p.goal.heading = bad; }) == "goal.heading_rad");
  }
  CHECK(RefusedAfter([](PlanProblem& p) { p.goal.heading = -6.28; }).empty());
  for (const double bad : {kNan, kInfinity, -0.1}) {
    CHECK(RefusedAfter([&](PlanProblem& p) { p.position_tolerance_m = bad; }) ==
          "position_tolerance_m");
    CHECK(RefusedAfter([&](PlanProblem& p) { p.heading_tolerance_rad = bad; }) ==
          "heading_tolerance_rad");
    CHECK(RefusedAfter([&](PlanProblem& p) { p.max_duration_seconds = bad; }) ==
          "max_duration_seconds");
    CHECK(RefusedAfter([&](PlanProblem& p) { p.effort = bad; }) == "effort");
    CHECK(RefusedAfter([&](PlanProblem& p) { p.frame_rate_hz = bad; }) == "frame_rate_hz");
    CHECK(RefusedAfter([&](PlanProblem& p) { p.leg_length_m = bad; }) == "leg_length_m");
  }
  for (const double bad : {kNan, 0.0, -1.0, 1.01}) {
    CHECK(RefusedAfter([&](PlanProblem& p) { p.speed_limit_scale = bad; }) == "speed_limit_scale");
  }
  CHECK(RefusedAfter([](PlanProblem& p) { p.speed_limit_scale = 0.01; }).empty());
  for (const double bad : {kNan, kInfinity, 0.0, -1.0, 1.1e6}) {
    CHECK(RefusedAfter([&](PlanProblem& p) { p.max_joint_acceleration = bad; }) ==
          "max_joint_acceleration");
  }
  CHECK(RefusedAfter([](PlanProblem& p) { p.max_duration_seconds = 121; }) ==
        "max_duration_seconds");
  CHECK(RefusedAfter([](PlanProblem& p) { p.coarse_layer = -1; }) == "coarse_layer");
  CHECK(RefusedAfter([](PlanProblem& p) { p.coarse_layer = 0; }) == "coarse_layer");
  CHECK(RefusedAfter([](PlanProblem& p) { p.frame_rate_hz = 0; }) == "frame_rate_hz");
  CHECK(RefusedAfter([](PlanProblem& p) { p.coarse_layer = 1 + TwoClips().layer_count(); }) ==
        "coarse_layer");
  CHECK(RefusedAfter([](PlanProblem& p) { p.alternative_count = 11; }) == "alternative_count");
  CHECK(RefusedAfter([](PlanProblem& p) {
          p.playable.labels = {TwoClips().clips()[0].label(), "fly"};
        }) == "labels[1]");
}

TEST_CASE("CheckProblem: too many frames in total are refused", "[core][planning]") {
  CHECK(RefusedAfter([](PlanProblem& p) {
          p.frame_rate_hz = 1000;
          p.max_duration_seconds = 120;
          p.alternative_count = 1;
        }) == "frame_rate_hz");
}

TEST_CASE("CheckProblem: each wrong obstacle is named", "[core][planning]") {
  const auto refused = [](const auto& change) {
    return RefusedAfter([&](PlanProblem& p) { change(p.obstacles); });
  };
  CHECK(refused([](Obstacles& o) { o.clearance_m = -0.1; }) == "obstacles.clearance_m");
  CHECK(refused([](Obstacles& o) { o.clearance_m = kNan; }) == "obstacles.clearance_m");
  CHECK(refused([](Obstacles& o) { o.discs[0].radius_m = 0; }) == "obstacles.discs[0].radius_m");
  CHECK(refused([](Obstacles& o) { o.discs[0].radius_m = kNan; }) == "obstacles.discs[0].radius_m");
  CHECK(refused([](Obstacles& o) { o.discs[0].centre.y() = kInfinity; }) ==
        "obstacles.discs[0].centre.y_m");
  CHECK(refused([](Obstacles& o) { o.polygons[0].corners[1].x() = kNan; }) ==
        "obstacles.polygons[0].corners[1].x_m");
  CHECK(refused([](Obstacles& o) { o.polygons[0].corners.pop_back(); }) ==
        "obstacles.polygons[0].corners");
  CHECK(refused([](Obstacles& o) { o.polygons.emplace_back(); }) ==
        "obstacles.polygons[1].corners");
  // The polygon intersects itself.
  CHECK(refused([](Obstacles& o) {
          o.polygons[0].corners.push_back({1, 1});
        }) == "obstacles.polygons[0].corners");
  CHECK(refused([](Obstacles& o) { o.discs.resize(1000, o.discs[0]); }) == "obstacles");
  CHECK(refused([](Obstacles& o) { o.polygons[0].corners.resize(10'001); }) ==
        "obstacles.polygons");
  CHECK(refused([](Obstacles& o) { o.polygons[0].corners.resize(2'001); }) ==
        "obstacles.polygons[0].corners");
}

}  // namespace
}  // namespace motiondb::core::problem_check_test
