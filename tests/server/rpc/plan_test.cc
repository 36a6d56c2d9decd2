// Responses of Plan, over a real socket.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <thread>

#include "core/format/motion_file.h"
#include "core/motion/forward_kinematics.h"
#include "tests/server/rpc/plan_support.h"
#include "tests/support/packed_floats.h"

namespace motiondb::tests::plan_test {
namespace {

using Stub = v1::QueryService::Stub;
using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// Removes the fields in which two responses to one request may differ.
std::string WithoutTimes(v1::PlanResponse response) {
  response.mutable_effort()->clear_search_seconds();
  response.mutable_effort()->clear_total_seconds();
  return response.SerializeAsString();
}

TEST_CASE("Plan: walks to a goal ahead", "[server][rpc][plan]") {
  const auto answer = AskPlan(PlanServer(), WalkAhead());
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  const v1::PlanResponse& response = answer.response;
  INFO(response.missing());
  CHECK(response.outcome() == v1::PLAN_OUTCOME_EXACT);
  CHECK(response.missing().empty());
  CHECK(response.leg_length_m() == Approx(0.82).margin(0.05));
  CHECK(response.alternatives_size() == 0);
  CHECK(response.effort().expansions() > 0);
  CHECK(response.effort().search_seconds() > 0);
  CHECK(response.effort().total_seconds() >= response.effort().search_seconds());

  const v1::PlannedMotion& motion = response.motion();
  CHECK(motion.outcome() == v1::PLAN_OUTCOME_EXACT);
  REQUIRE(motion.segments_size() >= 1);
  CHECK(motion.segments(0).clip() == "databases/db/clips/walk");
  CHECK(motion.segments(0).start_seconds() == Approx(0.2).margin(0.02));
  const int frames = motion.frame_count();
  CHECK(motion.frame_rate_hz() == 60);
  CHECK(motion.quality().duration_seconds() == Approx((frames - 1) / 60.0).margin(0.03));
  REQUIRE(motion.root_size() == frames);
  CHECK(std::hypot(motion.root(0).x_m(), motion.root(0).y_m()) < 0.01);
  const v1::FloorPose& end = motion.root(frames - 1);
  CHECK(std::hypot(end.x_m() - 1, end.y_m()) < 0.1);
  CHECK(std::hypot(end.x_m() - 1, end.y_m()) ==
        Approx(motion.quality().position_error_m()).margin(1e-6));
  CHECK(motion.bottom_node_ids_size() == motion.coarse_node_ids_size());
  REQUIRE(motion.marker_names_size() == 10);
  CHECK(motion.marker_positions().size() == static_cast<std::size_t>(frames) * 3 * 10 * 4);
  // The body of the start: the figure with six channels at the hips and three elsewhere.
  CHECK(motion.dof_names_size() == 6 + 3 * 9);
  CHECK(motion.dof_names(0) == "Hips.tx");
  CHECK(motion.joint_angles().size() == static_cast<std::size_t>(frames) * 33 * 4);
  CHECK(!motion.has_file());
  CHECK(!motion.quality().has_smallest_clearance_m());
}

TEST_CASE("Plan: equal requests get equal plans", "[server][rpc][plan]") {
  v1::PlanRequest request = WalkAhead(0.8);
  request.set_alternative_count(2);
  request.set_seed(7);
  const auto first = AskPlan(PlanServer(), request);
  REQUIRE(first.status.ok());
  CHECK(WithoutTimes(AskPlan(PlanServer(), request).response) == WithoutTimes(first.response));
}

TEST_CASE("Plan: the files have the motion of the response", "[server][rpc][plan]") {
  v1::PlanRequest request = WalkAhead();
  request.set_include_files(true);
  request.set_frame_rate_hz(30);
  const auto answer = AskPlan(PlanServer(), request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  const v1::PlannedMotion& planned = answer.response.motion();
  CHECK(planned.frame_rate_hz() == 30);
  CHECK(planned.file().file_name() == "plan.bvh");
  const auto read =
      core::ReadMotionFile(core::FileFormat::kBvh, {"plan.bvh", planned.file().data()});
  INFO(read.status().ToString());
  REQUIRE(read.ok());
  const auto& joints = std::get<core::JointMotion>(read->motion);
  CHECK(joints.frame_rate_hz == Approx(30));
  REQUIRE(joints.angles.rows() == planned.frame_count());
  const core::FrameMatrix positions = core::JointPositions(joints);
  const std::vector<float> markers = Unpack(planned.marker_positions());
  double farthest = 0;
  for (int m = 0; m < planned.marker_names_size(); ++m) {
    const int joint = joints.skeleton->FindJoint(planned.marker_names(m));
    REQUIRE(joint >= 0);
    for (int frame = 0; frame < planned.frame_count(); ++frame) {
      const Eigen::Map<const Eigen::RowVector3f> marker(
          markers.data() + 3 * (frame * planned.marker_names_size() + m));
      const auto distance = (positions.row(frame).segment<3>(3 * joint) - marker).norm();
      farthest = std::max(farthest, static_cast<double>(distance));
    }
  }
  CHECK(farthest < 0.01);
  // The joints of the response are those of the file.
  REQUIRE(planned.joint_names_size() == joints.skeleton->joint_count());
  CHECK(planned.joint_bones_size() == planned.joint_names_size() - 1);
  const std::vector<float> drawn = Unpack(planned.joint_positions());
  REQUIRE(static_cast<Eigen::Index>(drawn.size()) == positions.size());
  const Eigen::Map<const core::FrameMatrix> shown(drawn.data(), positions.rows(), positions.cols());
  CHECK((shown - positions).cwiseAbs().maxCoeff() < 0.01F);
  for (const v1::Bone& bone : planned.joint_bones()) {
    CHECK(joints.skeleton->joints()[bone.to_point()].parent == bone.from_point());
  }
}

TEST_CASE("Plan: starts from an observation", "[server][rpc][plan]") {
  v1::PlanRequest request = WalkAhead();
  *request.mutable_observation_start() = WalkObservation();
  request.add_labels("walk");
  const auto answer = AskPlan(PlanServer(), request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  REQUIRE(answer.response.motion().segments_size() >= 1);
  CHECK(answer.response.motion().segments(0).clip() == "databases/db/clips/walk");
}

TEST_CASE("Plan: an unreachable goal is reported", "[server][rpc][plan]") {
  v1::PlanRequest far = WalkAhead(100);
  far.set_max_duration_seconds(5);
  const auto unreachable = AskPlan(PlanServer(), far);
  INFO(unreachable.status.error_message());
  REQUIRE(unreachable.status.ok());
  CHECK(unreachable.response.outcome() == v1::PLAN_OUTCOME_UNREACHABLE);
  CHECK(!unreachable.response.missing().empty());
  CHECK(unreachable.response.effort().total_seconds() < 2);

  v1::PlanRequest inside = WalkAhead();
  v1::Disc& disc = *inside.mutable_obstacles()->add_discs();
  disc.mutable_centre()->set_x_m(1);
  disc.set_radius_m(0.2);
  const auto blocked = AskPlan(PlanServer(), inside);
  REQUIRE(blocked.status.ok());
  CHECK(blocked.response.outcome() == v1::PLAN_OUTCOME_UNREACHABLE);
  CHECK_THAT(blocked.response.missing(), Catch::Contains("obstacle"));
}

// A search that uses all its time: the walk leads straight ahead.
v1::PlanRequest SearchUntilDeadline() {
  v1::PlanRequest request = WalkAhead();
  request.mutable_goal()->set_y_m(0.9);
  request.mutable_search_timeout()->set_seconds(60);
  request.set_method(v1::PLAN_METHOD_RANDOM_SAMPLING);
  return request;
}

TEST_CASE("Plan: a deadline during the search returns the best plan so far",
          "[server][rpc][plan]") {
  const auto stub = PlanServer().NewStub<v1::QueryService>();
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + milliseconds(3000));
  v1::PlanResponse response;
  const grpc::Status status = stub->Plan(&context, SearchUntilDeadline(), &response);
  INFO(status.error_message() << response.missing());
  REQUIRE(status.ok());
  CHECK(response.outcome() == v1::PLAN_OUTCOME_DEADLINE);
  CHECK(!response.missing().empty());
  CHECK(response.motion().frame_count() > 1);
  CHECK(response.effort().search_seconds() > 1.4);
  CHECK(response.effort().search_seconds() < 2.9);
}

TEST_CASE("Plan: a cancelled call releases its thread immediately", "[server][rpc][plan]") {
  server::ServerOptions options;
  options.engine.rebuild_delay = milliseconds(50);
  options.engine.query_threads = 1;
  TestServer server(options);
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::QueryService>();
  v1::EstimateRequest estimate;
  estimate.set_database("databases/db");
  *estimate.mutable_observation() = WalkObservation();
  const auto ask = [&] {
    const auto begin = Clock::now();
    CHECK(Ask(*stub, &Stub::Estimate, estimate).status.ok());
    return Clock::now() - begin;
  };
  const auto alone = ask();
  // The minimum of a few, because the machine may be busy.
  auto shortest = Clock::duration::max();
  for (const int delay : {20, 50, 100, 150, 200}) {
    grpc::ClientContext context;
    grpc::Status status;
    std::thread planning([&] {
      v1::PlanResponse response;
      status = stub->Plan(&context, SearchUntilDeadline(), &response);
    });
    std::this_thread::sleep_for(milliseconds(delay));
    context.TryCancel();
    shortest = std::min(shortest, ask() - alone);
    planning.join();
    CHECK(status.error_code() == grpc::StatusCode::CANCELLED);
  }
  CHECK(shortest < milliseconds(50));
}

}  // namespace
}  // namespace motiondb::tests::plan_test
