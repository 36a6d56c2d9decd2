#include <catch2/catch.hpp>
#include <cmath>

#include "core/planning/goal.h"
#include "core/planning/plan.h"
#include "tests/core/planning/flat_footed_robot.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::planner_test {
namespace {

using tests::WalkingDatabase;

PlanProblem Problem(const FloorPose& goal) {
  PlanProblem problem;
  problem.start.clip = ClipMoment{"straight", 0.2};
  problem.goal = goal;
  return problem;
}

PlanAnswer Solve(const PlanProblem& problem, const PlanControl& control = {}) {
  auto answer = PlanMotion(WalkingDatabase(), tests::WalkerScheme(), problem, control);
  INFO(answer.status());
  REQUIRE(answer.ok());
  return *std::move(answer);
}

TEST_CASE("Plan: an exact plan's returned markers end at the goal", "[planning]") {
  const PlanProblem problem = Problem({1.6, 0.5, 0.6});
  const PlanAnswer answer = Solve(problem);
  REQUIRE(answer.outcome == PlanOutcome::kExact);
  CHECK(answer.missing.empty());
  const PlannedMotion& motion = answer.motions.front();
  const auto root = ReferenceFrames(tests::WalkerSet(), motion.markers);
  REQUIRE(root.ok());
  const Eigen::Index last = root->rows() - 1;
  const GoalError error =
      ErrorAt({(*root)(last, 0), (*root)(last, 1), (*root)(last, 2)}, problem.goal);
  CHECK(error.position_m <= problem.position_tolerance_m);
  CHECK(error.heading_rad <= problem.heading_tolerance_rad);
  CHECK(error.position_m == Approx(motion.quality.position_error_m));
  // It begins at the start.
  CHECK((*root)(0, 0) == Approx(0).margin(1e-4));
  CHECK((*root)(0, 1) == Approx(0).margin(1e-4));
  CHECK((*root)(0, 2) == Approx(0).margin(1e-4));
  CHECK(motion.quality.correction_m <= kMaxCorrection * motion.quality.length_m * 1.01);
}

TEST_CASE("Plan: node paths and segments describe the played frames", "[planning]") {
  const Model& model = WalkingDatabase();
  const PlannedMotion motion = Solve(Problem({1.6, 0.5, 0.6})).motions.front();
  std::size_t frames = 0;
  for (const PlayedSegment& segment : motion.segments) {
    CHECK(model.clip_of_frame(segment.first_frame) == model.clip_of_frame(segment.last_frame));
    frames += static_cast<std::size_t>(segment.last_frame - segment.first_frame + 1);
  }
  CHECK(motion.coarse_nodes.size() == frames);
  CHECK(motion.bottom_nodes.size() == frames);
  CHECK(motion.markers.positions_m.rows() == static_cast<Eigen::Index>(frames));
  for (const int node : motion.coarse_nodes) {
    CHECK(node < model.tree().node_count(motion.coarse_layer));
  }
  for (const int node : motion.bottom_nodes) {
    CHECK(node < model.tree().node_count(model.layer_count()));
  }
}

TEST_CASE("Plan: the answer has the requested frame rate and size", "[planning]") {
  PlanProblem problem = Problem({1.2, 0, 0});
  problem.frame_rate_hz = 100;
  problem.leg_length_m = 0.5;
  const PlanAnswer answer = Solve(problem);
  REQUIRE(answer.outcome == PlanOutcome::kExact);
  const PlannedMotion& motion = answer.motions.front();
  CHECK(answer.leg_length_m == 0.5);
  CHECK(motion.markers.frame_rate_hz == 100);
  CHECK(motion.markers.positions_m.rows() ==
        std::lround(motion.quality.duration_seconds * 100) + 1);
  const auto leg = EstimateLegLength(tests::WalkerSet(), motion.markers);
  REQUIRE(leg.ok());
  CHECK(*leg == Approx(0.5).epsilon(0.03));
}

TEST_CASE("Plan: unreachable goals are reported fast, with the reason", "[planning]") {
  PlanProblem far = Problem({100, 0, 0});
  far.max_duration_seconds = 5;
  PlanProblem inside = Problem({2, 0, 0});
  inside.obstacles.discs = {{{2, 0}, 0.5}};
  PlanProblem close = Problem({2, 0, 0});
  close.obstacles.discs = {{{2, 1}, 0.5}};
  close.obstacles.clearance_m = 0.8;
  PlanProblem enclosed = Problem({2, 0, 0});
  for (const double side : {-1.0, 1.0}) {
    enclosed.obstacles.polygons.push_back(
        {{{0.8, side}, {3.2, side}, {3.2, 1.1 * side}, {0.8, 1.1 * side}}});
    const double x = 2 + 1.15 * side;
    enclosed.obstacles.polygons.push_back({{{x, -1.1}, {x + 0.1, -1.1}, {x + 0.1, 1.1}, {x, 1.1}}});
  }
  PlanProblem trapped = Problem({2, 0, 0});
  trapped.obstacles.discs = {{{-0.2, 0}, 0.1}};
  PlanProblem round = Problem({0.3, 0, 3});
  round.max_duration_seconds = 0.5;
  const std::pair<const PlanProblem*, const char*> cases[] = {
      {&far, "100.00 m away"},
      {&inside, "inside an obstacle"},
      {&close, "0.5 m from an obstacle"},
      {&enclosed, "block every path to the goal"},
      {&round, "3.00 rad"},
      {&trapped, "the start is 0.1 m from an obstacle"}};
  for (const auto& [problem, why] : cases) {
    int over = 0;
    const PlanAnswer answer = Solve(*problem, {.search_over = [&] { ++over; }});
    CHECK(answer.outcome == PlanOutcome::kUnreachable);
    CHECK_THAT(answer.missing, Catch::Contains(why));
    CHECK(answer.effort.expansions == 0);
    CHECK(over == 1);
  }
}

TEST_CASE("Plan: unreachable after an exhaustive search, deadline after a timeout", "[planning]") {
  PlanProblem problem = Problem({0.3, 0, 0.9});  // no clip rotates on the spot
  problem.max_duration_seconds = 1.5;
  const PlanAnswer tried = Solve(problem);
  CHECK(tried.outcome == PlanOutcome::kUnreachable);
  CHECK_THAT(tried.missing, Catch::Contains("the search was exhaustive"));
  REQUIRE(tried.motions.size() == 1);  // the nearest motion
  CHECK(tried.motions.front().outcome == PlanOutcome::kApproximate);

  problem.goal = {-6, 5, 2};
  problem.max_duration_seconds = 30;
  int checks = 0;
  const PlanAnswer cut = Solve(problem, {.time_up = [&] { return ++checks > 5; }});
  CHECK(cut.outcome == PlanOutcome::kDeadline);
  CHECK_FALSE(cut.missing.empty());
  CHECK(cut.motions.size() == 1);
}

TEST_CASE("Plan: alternatives are other motions to the same goal", "[planning]") {
  PlanProblem problem = Problem({1.6, 0.3, 0.3});
  problem.alternative_count = 2;
  const PlanAnswer answer = Solve(problem);
  REQUIRE(answer.motions.size() > 1);
  for (std::size_t i = 0; i < answer.motions.size(); ++i) {
    CHECK(answer.motions[i].outcome == PlanOutcome::kExact);
    for (std::size_t j = 0; j < i; ++j) {
      CHECK((answer.motions[i].markers.positions_m.rows() !=
                 answer.motions[j].markers.positions_m.rows() ||
             answer.motions[i].markers.positions_m != answer.motions[j].markers.positions_m));
    }
  }
}

TEST_CASE("Plan: only clips with allowed labels are played", "[planning]") {
  const Model& model = WalkingDatabase();
  PlanProblem problem = Problem({1.2, 0.5, 0.8});
  problem.playable.labels = {"bend"};
  const PlanAnswer answer = Solve(problem);
  REQUIRE(answer.outcome == PlanOutcome::kExact);
  for (const PlayedSegment& segment : answer.motions.front().segments) {
    CHECK(model.clips()[model.clip_of_frame(segment.first_frame)].label() == "bend");
  }
}

TEST_CASE("Plan: the paper's random sampling returns the bottom nodes' means", "[planning]") {
  const Model& model = WalkingDatabase();
  PlanProblem problem = Problem({1.0, 0.1, 0.1});
  problem.method = PlanMethod::kRandomSampling;
  const PlanAnswer answer = Solve(problem);
  REQUIRE_FALSE(answer.motions.empty());
  const PlannedMotion& motion = answer.motions.front();
  // The first frame is at the origin: it is the mean, in metres.
  const int branch = model.tree().branch(model.layer_count(), motion.bottom_nodes.front());
  const Eigen::RowVectorXf mean =
      model.gaussians().means().row(branch).cwiseProduct(model.scale().divisor);
  const int toe = tests::WalkerIndex(0, tests::kToe);
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(motion.markers.positions_m(0, 3 * toe + axis) ==
          Approx(answer.leg_length_m * static_cast<double>(mean[6 * toe + axis])).margin(1e-5));
  }
}

TEST_CASE("Plan: an invalid number is refused with its field", "[planning]") {
  const auto refused = [](const PlanProblem& problem) {
    const auto answer = PlanMotion(WalkingDatabase(), tests::WalkerScheme(), problem);
    CHECK(answer.status().code() == absl::StatusCode::kInvalidArgument);
    return std::string(answer.status().message());
  };
  PlanProblem problem = Problem({std::nan(""), 0, 0});
  CHECK_THAT(refused(problem), Catch::Contains("goal"));
  problem = Problem({1, 0, 0});
  problem.position_tolerance_m = -1;
  CHECK_THAT(refused(problem), Catch::Contains("position_tolerance_m"));
  problem = Problem({1, 0, 0});
  problem.max_duration_seconds = std::nan("");
  CHECK_THAT(refused(problem), Catch::Contains("max_duration_seconds"));
  problem = Problem({1, 0, 0});
  problem.alternative_count = -1;
  CHECK_THAT(refused(problem), Catch::Contains("alternative_count"));
  problem = Problem({1, 0, 0});
  problem.leg_length_m = -0.8;
  CHECK_THAT(refused(problem), Catch::Contains("leg_length_m"));
}

TEST_CASE("Plan: a cancelled call ends at the next check, at any point", "[planning]") {
  PlanProblem problem = Problem({1.6, 0.5, 0.6});
  problem.obstacles.discs = {{{0.8, -0.8}, 0.2}};
  problem.skeleton = tests::FlatFootedRobot();
  problem.flat_soles = true;
  int total_checks = 0;
  bool searched = false;
  int after_search = 0;
  const auto whole = PlanMotion(WalkingDatabase(), tests::RobotScheme(), problem,
                                {.cancelled =
                                     [&] {
                                       ++total_checks;
                                       after_search += searched;
                                       return false;
                                     },
                                 .search_over = [&] { searched = true; }});
  REQUIRE(whole.ok());
  REQUIRE(total_checks > 100);
  REQUIRE(after_search > 50);  // during synthesis
  for (int at = 1; at <= total_checks; at += 1 + total_checks / 20) {
    int checks = 0;
    const auto answer = PlanMotion(WalkingDatabase(), tests::RobotScheme(), problem,
                                   {.cancelled = [&] { return ++checks >= at; }});
    CHECK(answer.status().code() == absl::StatusCode::kCancelled);
    CHECK(checks == at);
  }
}

TEST_CASE("Plan: a goal near an obstacle is approached from the clear side", "[planning]") {
  PlanProblem problem = Problem({2, 0, 0});
  problem.heading_tolerance_rad = 0.5;
  problem.position_tolerance_m = 0.3;
  problem.obstacles.discs = {{{2, 0.55}, 0.4}};  // 0.15 m from the goal
  problem.obstacles.clearance_m = 0.2;
  const PlanAnswer answer = Solve(problem);
  CHECK(answer.outcome == PlanOutcome::kExact);
  CHECK(answer.motions.front().quality.smallest_clearance_m.value() >= 0.2);
}

TEST_CASE("Plan: the end is exact at any frame rate", "[planning]") {
  PlanProblem problem = Problem({1.6, 0.5, 0.6});
  for (const double rate : {1.0, 7.0, 25.0, 60.0, 240.0}) {
    problem.frame_rate_hz = rate;
    const PlanAnswer answer = Solve(problem);
    INFO(rate << " Hz: " << answer.missing);
    CHECK(answer.outcome == PlanOutcome::kExact);
  }
}

TEST_CASE("Plan: a start late in its clip continues in another clip", "[planning]") {
  PlanProblem problem = Problem({1.2, 0, 0});
  problem.start.clip = ClipMoment{"straight", 3.9};
  CHECK(Solve(problem).outcome == PlanOutcome::kExact);
}

TEST_CASE("Plan: after a timeout, no alternatives are added to an existing motion", "[planning]") {
  PlanProblem problem = Problem({1.6, 0.3, 0.3});
  problem.alternative_count = 4;
  bool searched = false;
  const PlanAnswer answer = Solve(
      problem, {.time_up = [&] { return searched; }, .search_over = [&] { searched = true; }});
  CHECK(answer.outcome == PlanOutcome::kExact);
  CHECK(answer.motions.size() == 1);
}

}  // namespace
}  // namespace motiondb::core::planner_test
