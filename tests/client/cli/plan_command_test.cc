#include <motiondb/v1/plan.pb.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/client/fake_server.h"
#include "tests/client/planned_motion.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::plan_command_test {
namespace {

using Catch::Contains;
using Catch::StartsWith;

v1::PlanResponse WithFiles(int alternatives) {
  v1::PlanResponse response = QuarterCirclePlan();
  response.mutable_motion()->mutable_file()->set_data("best");
  for (int i = 0; i < alternatives; ++i) {
    *response.add_alternatives() = QuarterCircle(0.9);
    response.mutable_alternatives(i)->mutable_file()->set_data("other " + std::to_string(i));
  }
  return response;
}

v1::PlanRequest Sent(FakeServer& server) {
  const auto requests = server.Requests<v1::PlanRequest>("Plan");
  REQUIRE(!requests.empty());
  return requests.back();
}

TEST_CASE("motiondb plan: needs only a goal", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", QuarterCirclePlan());
  const auto result = RunMotiondb(server.address(), {"plan", "walks", "--goal", "-2,1,-0.5"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("EXACT\n") && Contains("07_01 0.50-2.50 s"));
  const v1::PlanRequest request = Sent(server);
  CHECK(request.database() == "databases/walks");
  CHECK(request.goal().x_m() == -2);
  CHECK(request.goal().y_m() == 1);
  CHECK(request.goal().heading_rad() == -0.5);
  CHECK(request.start_case() == v1::PlanRequest::START_NOT_SET);
  CHECK(request.body_case() == v1::PlanRequest::BODY_NOT_SET);
  CHECK(!request.has_position_tolerance_m());
  CHECK(!request.has_obstacles());
  CHECK(request.max_duration_seconds() == 30);
  CHECK(request.search_timeout().seconds() == 5);
  CHECK(request.method() == v1::PLAN_METHOD_SEGMENT_SEARCH);
  CHECK(!request.include_files());
}

TEST_CASE("motiondb plan: angles in degrees where they are stated", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", QuarterCirclePlan());
  REQUIRE(RunMotiondb(server.address(),
                      {"plan", "walks", "--goal", "1,0.6,30deg", "--tolerance", "0.2,5deg"})
              .exit_code == 0);
  CHECK(Sent(server).goal().x_m() == 1);
  CHECK(Sent(server).goal().heading_rad() == Approx(0.5235987756));
  CHECK(Sent(server).heading_tolerance_rad() == Approx(0.0872664626));
  REQUIRE(RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,0,-0.5rad"}).exit_code == 0);
  CHECK(Sent(server).goal().heading_rad() == -0.5);
}

TEST_CASE("motiondb plan: --force accepts a heading of many turns", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", QuarterCirclePlan());
  REQUIRE(RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,0,90"}).exit_code == 0);
  CHECK(Sent(server).goal().heading_rad() == 90);  // for the server to refuse
  REQUIRE(
      RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,0,90", "--force"}).exit_code ==
      0);
  CHECK(Sent(server).goal().heading_rad() == Approx(90 - 28 * 3.14159265358979));
}

TEST_CASE("motiondb plan: options are sent in the request", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", QuarterCirclePlan());
  const auto result = RunMotiondb(server.address(), {"plan",
                                                     "walks",
                                                     "--goal",
                                                     "2,1,0",
                                                     "--start",
                                                     "07_01@1.25",
                                                     "--tolerance",
                                                     "0.2,0.3",
                                                     "--max-duration",
                                                     "10",
                                                     "--search-seconds",
                                                     "0.5",
                                                     "--layer",
                                                     "9",
                                                     "--label",
                                                     "walk",
                                                     "--label",
                                                     "turn",
                                                     "--disc",
                                                     "1,0.5,0.25",
                                                     "--disc",
                                                     "-1,-1,2",
                                                     "--polygon",
                                                     "0,1,1,1,1,2",
                                                     "--clearance",
                                                     "0.1",
                                                     "--seed",
                                                     "42",
                                                     "--alternatives",
                                                     "2",
                                                     "--skeleton",
                                                     "cmu07",
                                                     "--ignore-joint-limits",
                                                     "--speed-limit-scale",
                                                     "0.5",
                                                     "--max-joint-acceleration",
                                                     "40",
                                                     "--frame-rate",
                                                     "30",
                                                     "--method",
                                                     "random",
                                                     "--json"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("{\"outcome\":\"EXACT\",\"missing\":\"\","));
  const v1::PlanRequest request = Sent(server);
  CHECK(request.clip_start().clip() == "databases/walks/clips/07_01");
  CHECK(request.clip_start().seconds() == 1.25);
  CHECK(request.position_tolerance_m() == 0.2);
  CHECK(request.heading_tolerance_rad() == 0.3);
  CHECK(request.max_duration_seconds() == 10);
  CHECK(request.search_timeout().nanos() == 500'000'000);
  CHECK(request.coarse_layer() == 9);
  REQUIRE(request.labels_size() == 2);
  CHECK(request.labels(1) == "turn");
  REQUIRE(request.obstacles().discs_size() == 2);
  CHECK(request.obstacles().discs(1).centre().x_m() == -1);
  CHECK(request.obstacles().discs(1).radius_m() == 2);
  REQUIRE(request.obstacles().polygons_size() == 1);
  REQUIRE(request.obstacles().polygons(0).corners_size() == 3);
  CHECK(request.obstacles().polygons(0).corners(2).y_m() == 2);
  CHECK(request.obstacles().clearance_m() == 0.1);
  CHECK(request.seed() == 42);
  CHECK(request.alternative_count() == 2);
  CHECK(request.skeleton() == "databases/walks/skeletons/cmu07");
  CHECK(request.ignore_joint_limits());
  CHECK(request.speed_limit_scale() == 0.5);
  CHECK(request.max_joint_acceleration() == 40);
  CHECK(request.frame_rate_hz() == 30);
  CHECK(request.method() == v1::PLAN_METHOD_RANDOM_SAMPLING);
}

TEST_CASE("motiondb plan: files are sent in the request", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", QuarterCirclePlan());
  const TemporaryFolder folder;
  const std::string seen = folder.Write("seen.bvh", "HIERARCHY").string();
  const std::string robot = folder.Write("g1.URDF.gz", "<robot/>").string();
  CHECK(RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,0,0", "--observation", seen,
                                       "--skeleton", robot})
            .exit_code == 0);
  const v1::PlanRequest request = Sent(server);
  CHECK(request.observation_start().file().file_name() == "seen.bvh");
  CHECK(request.observation_start().file().data() == "HIERARCHY");
  CHECK(request.robot().file_name() == "g1.URDF.gz");
  CHECK(request.robot().urdf() == "<robot/>");
}

TEST_CASE("motiondb plan: writes motions and the picture", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", WithFiles(2));
  const TemporaryFolder folder;
  const auto result = RunMotiondb(
      server.address(), {"plan", "walks", "--goal", "1,1,1.57", "--alternatives", "2", "--out",
                         (folder / "to.bvh").string(), "--plot", (folder / "to.svg").string()});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(Sent(server).include_files());
  CHECK(ReadFile(folder / "to.bvh") == "best");
  CHECK(ReadFile(folder / "to-2.bvh") == "other 0");
  CHECK(ReadFile(folder / "to-3.bvh") == "other 1");
  CHECK_THAT(ReadFile(folder / "to.svg"), StartsWith("<?xml"));
  CHECK_THAT(result.out, Contains("wrote " + (folder / "to-3.bvh").string() + "\n"));
  const auto files = std::distance(std::filesystem::directory_iterator(folder.path()),
                                   std::filesystem::directory_iterator());
  CHECK(files == 4);  // no temporary file is left
}

TEST_CASE("motiondb plan: without a motion, writes only the picture", "[client][cli]") {
  FakeServer server;
  v1::PlanResponse nowhere;
  nowhere.set_outcome(v1::PLAN_OUTCOME_UNREACHABLE);
  nowhere.set_missing("the goal is within an obstacle");
  server.Answer("Plan", nowhere);
  const TemporaryFolder folder;
  const auto asked = RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,1,0"});
  CHECK(asked.exit_code == 3);
  CHECK_THAT(asked.out, StartsWith("UNREACHABLE: the goal is within an obstacle\n"));
  CHECK(asked.err == "motiondb: the goal cannot be reached: the goal is within an obstacle\n");
  const auto json = RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,1,0", "--json"});
  CHECK(json.exit_code == 3);
  CHECK_THAT(json.out, StartsWith("{\"outcome\":\"UNREACHABLE\""));
  const auto written = RunMotiondb(
      server.address(), {"plan", "walks", "--goal", "1,1,0", "--out", (folder / "to.bvh").string(),
                         "--plot", (folder / "to.svg").string()});
  CHECK(written.exit_code == 3);
  CHECK_THAT(written.out, StartsWith("UNREACHABLE"));
  CHECK_THAT(written.err, Contains("no motion to write") && Contains("within an obstacle"));
  CHECK(!std::filesystem::exists(folder / "to.bvh"));
  CHECK(std::filesystem::exists(folder / "to.svg"));
}

TEST_CASE("motiondb plan: writes a partial motion, and fails", "[client][cli]") {
  FakeServer server;
  v1::PlanResponse part = WithFiles(0);
  part.set_outcome(v1::PLAN_OUTCOME_UNREACHABLE);
  server.Answer("Plan", part);
  const TemporaryFolder folder;
  const auto result = RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,1,0", "--out",
                                                     (folder / "to.bvh").string()});
  CHECK(result.exit_code == 3);
  CHECK(ReadFile(folder / "to.bvh") == "best");
  // A write error has another exit code.
  CHECK(RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,1,0", "--out",
                                       (folder / "none/to.bvh").string()})
            .exit_code == 1);
  // An expired deadline is not UNREACHABLE.
  FakeServer slow;
  part.set_outcome(v1::PLAN_OUTCOME_DEADLINE);
  slow.Answer("Plan", part);
  CHECK(RunMotiondb(slow.address(), {"plan", "walks", "--goal", "1,1,0"}).exit_code == 0);
}

TEST_CASE("motiondb plan: fails if a file cannot be written", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", WithFiles(0));
  const TemporaryFolder folder;
  const auto result = RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,1,0", "--out",
                                                     (folder / "none/to.bvh").string()});
  CHECK(result.exit_code == 1);
  CHECK_THAT(result.err, Contains("none/to.bvh"));
  // It is found before the search, also of alternatives.
  std::filesystem::create_directory(folder / "to-2.bvh");
  CHECK(RunMotiondb(server.address(), {"plan", "walks", "--goal", "1,1,0", "--alternatives", "1",
                                       "--out", (folder / "to.bvh").string()})
            .exit_code == 1);
  CHECK(server.Requests<v1::PlanRequest>("Plan").empty());
}

TEST_CASE("motiondb plan: refuses invalid options before the call", "[client][cli]") {
  FakeServer server;
  server.Answer("Plan", QuarterCirclePlan());
  const TemporaryFolder folder;
  const std::string robot = folder.Write("h1.urdf", "<robot/>").string();
  const auto refused = [&](int exit_code, const std::string& expected,
                           const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"plan", "walks"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const auto result = RunMotiondb(server.address(), arguments);
    CAPTURE(result.err);
    CHECK(result.exit_code == exit_code);
    CHECK(result.out == "");
    CHECK_THAT(result.err, StartsWith("motiondb: ") && Contains(expected));
  };
  refused(2, "--goal", {});
  refused(2, "--goal", {"--goal", "2,1"});
  refused(2, "--goal", {"--goal", "2,nan,0"});
  refused(2, "--goal", {"--goal", "2,1,"});
  refused(2, "--goal", {"--goal", "2deg,1,0"});  // only angles
  refused(2, "--goal", {"--goal", "2,1,deg"});
  refused(2, "--disc", {"--goal", "2,1,0", "--disc", "1,1,3deg"});
  refused(2, "--start", {"--goal", "2,1,0", "--start", "07_01"});
  refused(2, "--start", {"--goal", "2,1,0", "--start", "07_01@-1"});
  refused(2, "--observation", {"--goal", "2,1,0", "--start", "a@1", "--observation", "b.bvh"});
  refused(2, "--tolerance", {"--goal", "2,1,0", "--tolerance", "-0.1,0.1"});
  refused(2, "--disc", {"--goal", "2,1,0", "--disc", "1,1,0"});
  refused(2, "--polygon", {"--goal", "2,1,0", "--polygon", "0,0,1,1"});
  refused(2, "--polygon", {"--goal", "2,1,0", "--polygon", "0,0,1,1,2,0,3"});
  refused(2, "--method", {"--goal", "2,1,0", "--method", "luck"});
  refused(2, "--alternatives", {"--goal", "2,1,0", "--alternatives", "11"});
  refused(2, "bvh|trc|c3d|csv|npz|glb", {"--goal", "2,1,0", "--out", "plan.fbx"});
  refused(2, "bvh|trc|c3d|csv|npz|glb", {"--goal", "2,1,0", "--out", "plan"});
  refused(2, "FILE.svg", {"--goal", "2,1,0", "--plot", "plan.pdf"});
  refused(1, "none.urdf", {"--goal", "2,1,0", "--skeleton", "none.urdf"});
  CHECK(server.Requests<v1::PlanRequest>("Plan").empty());
}

}  // namespace
}  // namespace motiondb::tests::plan_command_test
