// Invalid requests of Plan, and the bodies of a plan.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "tests/server/rpc/plan_support.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/humanoid_bvh.h"

namespace motiondb::tests::plan_request_test {
namespace {

using Catch::Contains;

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

// A robot with the stick figure's joints, at half its size.
std::string StickRobot() {
  std::string text = "<robot name=\"stick\">\n  <link name=\"Hips\"/>\n";
  const auto joint = [&](const char* name, const char* parent, double x, double y, double z) {
    text += fmt::format(
        "  <link name=\"{0}\"/>\n"
        "  <joint name=\"{0}\" type=\"revolute\">\n"
        "    <parent link=\"{1}\"/><child link=\"{0}\"/>\n"
        "    <origin xyz=\"{2} {3} {4}\"/><axis xyz=\"0 1 0\"/>\n"
        "    <limit lower=\"-2.5\" upper=\"2.5\" effort=\"1\" velocity=\"9\"/>\n"
        "  </joint>\n",
        name, parent, x, y, z);
  };
  for (const auto& [side, y] : {std::pair{"Left", 0.045}, {"Right", -0.045}}) {
    const std::string hip = std::string(side) + "UpLeg";
    const std::string knee = std::string(side) + "Leg";
    const std::string ankle = std::string(side) + "Foot";
    joint(hip.c_str(), "Hips", 0, y, -0.02);
    joint(knee.c_str(), hip.c_str(), 0, 0, -0.21);
    joint(ankle.c_str(), knee.c_str(), 0, 0, -0.2);
  }
  joint("Spine", "Hips", 0, 0, 0.1);
  joint("RightArm", "Spine", 0, -0.09, 0.14);
  joint("Head", "Spine", 0, 0, 0.2);
  return text + "</robot>\n";
}

// A walk of hips and legs as markers without a skeleton.
std::string WalkingMarkers() {
  constexpr const char* kNames[] = {"LeftUpLeg", "RightUpLeg", "LeftLeg",
                                    "RightLeg",  "LeftFoot",   "RightFoot"};
  constexpr double kHeights[] = {0.9, 0.9, 0.5, 0.5, 0.1, 0.1};
  constexpr int kFrames = 120;
  std::string text = fmt::format(
      "PathFileType\t4\t(X/Y/Z)\twalk.trc\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n60\t60\t{}\t6\tm\nFrame#\tTime",
      kFrames);
  for (const char* name : kNames) text += fmt::format("\t{}\t\t", name);
  text += "\n\t";
  for (int m = 1; m <= 6; ++m) text += fmt::format("\tX{0}\tY{0}\tZ{0}", m);
  text += "\n\n";
  for (int frame = 0; frame < kFrames; ++frame) {
    const double seconds = frame / 60.0;
    text += fmt::format("{}\t{:.5f}", frame + 1, seconds);
    for (int m = 0; m < 6; ++m) {
      const double side = m % 2 == 0 ? 1 : -1;
      const double swing = side * std::sin(2 * 3.14159 * seconds) * (0.9 - kHeights[m]) / 3;
      // In the file y is up, z to the front and x to the left.
      text +=
          fmt::format("\t{:.5f}\t{:.5f}\t{:.5f}", 0.1 * side, kHeights[m], 1.2 * seconds + swing);
    }
    text += "\n";
  }
  return text;
}

TEST_CASE("Plan: the error names the invalid field", "[server][rpc][plan]") {
  const auto expect = [](const std::string& field, const auto& change) {
    v1::PlanRequest request = WalkAhead();
    change(request);
    const auto answer = AskPlan(PlanServer(), request);
    INFO(field << ": " << answer.status.error_message());
    CHECK(answer.status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(answer.status) == field);
    return answer.status.error_message();
  };
  expect("database", [](auto& r) { r.set_database("db"); });
  expect("goal", [](auto& r) { r.clear_goal(); });
  expect("goal.x_m", [](auto& r) { r.mutable_goal()->set_x_m(kNan); });
  expect("goal.x_m", [](auto& r) { r.mutable_goal()->set_x_m(1001); });
  expect("goal.y_m", [](auto& r) { r.mutable_goal()->set_y_m(-kInfinity); });
  expect("goal.heading_rad", [](auto& r) { r.mutable_goal()->set_heading_rad(kNan); });
  CHECK_THAT(expect("goal.heading_rad", [](auto& r) { r.mutable_goal()->set_heading_rad(90); }),
             Catch::Contains("90 degrees are 1.571 radians"));
  expect("position_tolerance_m", [](auto& r) { r.set_position_tolerance_m(-0.1); });
  expect("position_tolerance_m", [](auto& r) { r.set_position_tolerance_m(kNan); });
  expect("heading_tolerance_rad", [](auto& r) { r.set_heading_tolerance_rad(-1); });
  expect("max_duration_seconds", [](auto& r) { r.set_max_duration_seconds(-1); });
  expect("max_duration_seconds", [](auto& r) { r.set_max_duration_seconds(120.5); });
  expect("search_timeout", [](auto& r) { r.mutable_search_timeout()->set_seconds(0); });
  expect("search_timeout", [](auto& r) { r.mutable_search_timeout()->set_seconds(-1); });
  expect("search_timeout", [](auto& r) { r.mutable_search_timeout()->set_seconds(61); });
  expect("coarse_layer", [](auto& r) { r.set_coarse_layer(-1); });
  expect("coarse_layer", [](auto& r) { r.set_coarse_layer(0); });
  expect("coarse_layer", [](auto& r) { r.set_coarse_layer(1000); });
  expect("alternative_count", [](auto& r) { r.set_alternative_count(11); });
  expect("alternative_count", [](auto& r) { r.set_alternative_count(-1); });
  expect("frame_rate_hz", [](auto& r) { r.set_frame_rate_hz(0.5); });
  expect("frame_rate_hz", [](auto& r) { r.set_frame_rate_hz(0); });
  expect("frame_rate_hz", [](auto& r) { r.set_frame_rate_hz(1001); });
  expect("frame_rate_hz", [](auto& r) { r.set_frame_rate_hz(kNan); });
  expect("frame_rate_hz", [](auto& r) {  // more than fits into a message
    r.set_frame_rate_hz(1000);
    r.set_max_duration_seconds(120);
    r.set_alternative_count(10);
  });
  expect("speed_limit_scale", [](auto& r) { r.set_speed_limit_scale(0); });
  expect("speed_limit_scale", [](auto& r) { r.set_speed_limit_scale(1.5); });
  expect("max_joint_acceleration", [](auto& r) { r.set_max_joint_acceleration(0); });
  expect("max_joint_acceleration", [](auto& r) { r.set_max_joint_acceleration(kInfinity); });
  expect("method", [](auto& r) { r.set_method(static_cast<v1::PlanMethod>(9)); });
  const std::string labels = expect("labels[1]", [](auto& r) {
    r.add_labels("walk");
    r.add_labels("fly");
  });
  CHECK_THAT(labels, Contains("'fly'") && Contains("squat, walk, wave"));
  expect("obstacles.clearance_m", [](auto& r) { r.mutable_obstacles()->set_clearance_m(-1); });
  expect("obstacles.polygons[0].corners", [](auto& r) {
    v1::Polygon& polygon = *r.mutable_obstacles()->add_polygons();
    polygon.add_corners();
    polygon.add_corners()->set_x_m(1);
  });
  expect("obstacles.discs[0].radius_m",
         [](auto& r) { r.mutable_obstacles()->add_discs()->mutable_centre(); });
}

TEST_CASE("Plan: the error names the invalid start", "[server][rpc][plan]") {
  const auto expect = [](const std::string& field, const auto& change) {
    v1::PlanRequest request = WalkAhead();
    change(request);
    const auto answer = AskPlan(PlanServer(), request);
    INFO(field << ": " << answer.status.error_message());
    CHECK(answer.status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(answer.status) == field);
  };
  expect("clip_start.clip", [](auto& r) { r.mutable_clip_start()->set_clip("walk"); });
  expect("clip_start.clip",
         [](auto& r) { r.mutable_clip_start()->set_clip("databases/other/clips/walk"); });
  expect("clip_start.clip",
         [](auto& r) { r.mutable_clip_start()->set_clip("databases/db/clips/none"); });
  expect("clip_start.seconds", [](auto& r) { r.mutable_clip_start()->set_seconds(-1); });
  expect("clip_start.seconds", [](auto& r) { r.mutable_clip_start()->set_seconds(2.5); });
  expect("clip_start.seconds", [](auto& r) { r.mutable_clip_start()->set_seconds(kNan); });
  expect("observation_start", [](auto& r) { r.mutable_observation_start(); });
  expect("observation_start.file.data", [](auto& r) {
    *r.mutable_observation_start() = WalkObservation();
    r.mutable_observation_start()->mutable_file()->set_data("nonsense");
  });
}

TEST_CASE("Plan: the database must exist and have a model", "[server][rpc][plan]") {
  v1::PlanRequest request = WalkAhead();
  request.set_database("databases/empty");
  CHECK(AskPlan(PlanServer(), request).status.error_code() ==
        grpc::StatusCode::FAILED_PRECONDITION);
  request.set_database("databases/none");
  CHECK(AskPlan(PlanServer(), request).status.error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("Plan: plays with a stored skeleton", "[server][rpc][plan]") {
  const auto clips = PlanServer().NewStub<v1::ClipService>();
  v1::ListSkeletonsRequest list;
  list.set_parent("databases/db");
  const auto stored = Ask(*clips, &v1::ClipService::Stub::ListSkeletons, list).response;
  REQUIRE(stored.skeletons_size() == 1);
  const std::string& name = stored.skeletons(0).name();
  v1::PlanRequest request = WalkAhead();
  request.set_skeleton(name);
  const auto answer = AskPlan(PlanServer(), request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(answer.response.motion().dof_names_size() == stored.skeletons(0).dof_count());
  CHECK(answer.response.skeleton() == name);
  for (const char* wrong :
       {"databases/db/skeletons/none", "databases/other/skeletons/Hips", "Hips"}) {
    request.set_skeleton(wrong);
    const auto refused = AskPlan(PlanServer(), request).status;
    INFO(refused.error_message());
    CHECK(refused.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(refused) == "skeleton");
  }
  request.set_skeleton("databases/db/skeletons/none");
  const auto unknown = AskPlan(PlanServer(), request).status;
  CHECK_THAT(unknown.error_message(), Contains(name.substr(name.rfind('/') + 1)));
  CHECK(ReasonOf(unknown) == "SKELETON_NOT_FOUND");
  request.clear_body();
  request.mutable_clip_start()->set_clip("databases/db/clips/none");
  CHECK(ReasonOf(AskPlan(PlanServer(), request).status) == "CLIP_NOT_FOUND");
}

TEST_CASE("Plan: plays with a robot at its own size", "[server][rpc][plan]") {
  v1::PlanRequest request = WalkAhead(0.5);
  request.mutable_robot()->set_file_name("stick.urdf");
  request.mutable_robot()->set_urdf(StickRobot());
  request.set_include_files(true);
  const auto answer = AskPlan(PlanServer(), request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(answer.response.leg_length_m() == Approx(0.41).margin(0.001));
  const v1::PlannedMotion& motion = answer.response.motion();
  CHECK(answer.response.skeleton().empty());
  REQUIRE(motion.dof_names_size() == 6 + 9);
  CHECK(motion.dof_names(5) == "Hips.rx");
  CHECK(motion.dof_names(6) == "LeftUpLeg");
  CHECK(motion.file().file_name() == "plan.csv");
  const std::string& csv = motion.file().data();
  CHECK(csv.starts_with("time_s,root_x_m,root_y_m,root_z_m,root_qx"));
  CHECK_THAT(csv.substr(0, csv.find('\n')), Contains(",LeftUpLeg,LeftLeg,LeftFoot,"));
  CHECK(std::count(csv.begin(), csv.end(), '\n') == motion.frame_count() + 1);

  request.mutable_robot()->set_urdf("<robot name=\"x\">\n<link/>\n</robot>");
  const auto broken = AskPlan(PlanServer(), request).status;
  CHECK(ViolatedFields(broken) == "robot.urdf");
  CHECK_THAT(broken.error_message(), Contains("stick.urdf:2"));
  request.mutable_robot()->set_urdf("<robot name=\"x\"><link name=\"base\"/></robot>");
  const auto unlike = AskPlan(PlanServer(), request).status;
  INFO(unlike.error_message());
  CHECK(ViolatedFields(unlike) == "robot.urdf");
  request.mutable_robot()->clear_file_name();
  CHECK(ViolatedFields(AskPlan(PlanServer(), request).status) == "robot.file_name");
}

TEST_CASE("Plan: on a skeleton that no mapping of the database knows", "[server][rpc][plan]") {
  TestServer server;
  const auto databases = server.NewStub<v1::DatabaseService>();
  v1::CreateDatabaseRequest create;
  create.set_database_id("db");
  REQUIRE(Ask(*databases, &v1::DatabaseService::Stub::CreateDatabase, create).status.ok());
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name("swing.bvh");
  v1::IngestClipResponse ingested;
  REQUIRE(server.Ingest(header, HumanoidBvh(100, 90), &ingested).ok());
  CHECK_THAT(ingested.clip().source_report(), Contains("joints mapped automatically"));
  server.Wait(ingested.operation().name());
  v1::PlanRequest request = WalkAhead();
  request.clear_start();
  request.mutable_goal()->set_x_m(0);
  const auto answer = AskPlan(server, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(answer.response.skeleton() == ingested.clip().skeleton());
  CHECK(answer.response.leg_length_m() == Approx(0.82).margin(0.01));
}

TEST_CASE("Plan: without a skeleton there are markers, but no files", "[server][rpc][plan]") {
  TestServer server;
  server.CreateDatabase("db");
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name("walk.trc");
  header.set_label("walk");
  v1::IngestClipResponse ingested;
  const grpc::Status status = server.Ingest(header, WalkingMarkers(), &ingested);
  INFO(status.error_message());
  REQUIRE(status.ok());
  server.Wait(ingested.operation().name());
  v1::PlanRequest request = WalkAhead();
  const auto answer = AskPlan(server, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(answer.response.outcome() == v1::PLAN_OUTCOME_EXACT);
  CHECK(answer.response.motion().marker_names_size() == 6);
  CHECK(answer.response.motion().dof_names_size() == 0);
  CHECK(answer.response.leg_length_m() == Approx(0.8).margin(0.1));
  request.set_include_files(true);
  const auto refused = AskPlan(server, request).status;
  CHECK(refused.error_code() == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK_THAT(refused.error_message(), Contains("--skeleton"));
}

}  // namespace
}  // namespace motiondb::tests::plan_request_test
