#include "server/translate/plan_message.h"

#include <catch2/catch.hpp>
#include <limits>

#include "motiondb/v1/plan.pb.h"
#include "motiondb/v1/view.pb.h"
#include "tests/support/packed_floats.h"
#include "tests/support/synthetic_states.h"

namespace motiondb::server::plan_message_test {
namespace {

using Names = std::vector<std::string>;

core::Dof Turn(const Eigen::Vector3d& axis) {
  return {.kind = core::Dof::Kind::kRotation, .axis = axis};
}

// A free base, a hinge, a fixed link, and a joint with two rotations about one axis.
std::shared_ptr<const core::Skeleton> Arm() {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up = {0.1, -0.1, -std::sqrt(0.98)};
  std::vector<core::Joint> joints(4);
  joints[0].name = "base";
  joints[0].dofs = {{.kind = core::Dof::Kind::kTranslation, .axis = x}, Turn(up)};
  joints[1] = {.name = "elbow", .parent = 0, .dofs = {Turn(x)}};
  joints[2] = {.name = "plate", .parent = 1};
  joints[3] = {.name = "wrist", .parent = 2, .dofs = {Turn(z), Turn(x), Turn(z)}};
  auto skeleton = core::Skeleton::Create("arm", joints);
  REQUIRE(skeleton.ok());
  return std::make_shared<const core::Skeleton>(*std::move(skeleton));
}

// Two frames of a plan on a model of two clips of 40 frames at 60 Hz.
core::PlannedMotion Motion() {
  core::PlannedMotion motion;
  motion.outcome = core::PlanOutcome::kApproximate;
  motion.missing = "a metre";
  motion.segments = {{10, 22}, {46, 52}};
  motion.coarse_layer = 2;
  motion.coarse_nodes = {1, 2};
  motion.bottom_nodes = {3, 4};
  motion.root.resize(2, 3);
  motion.root << 0, 0, 0, 0.5, -0.25, 0.125;
  motion.markers = {{"m0"}, 30, core::FrameMatrix::Constant(2, 3, 1.5F)};
  motion.quality.position_error_m = 0.5;
  motion.quality.motion.foot_slide_cm_per_s = 2;
  motion.quality.joint_limit_violations = 7;
  return motion;
}

void Set(const core::PlanAnswer& answer, v1::PlanResponse& message, const PlanBody& body = {},
         std::vector<ExportedMotion> files = {}) {
  const core::Model model = tests::SmallModel(2, 40, 4, 8, 1);
  SetPlan({.answer = answer, .body = body, .files = std::move(files)}, "db", model, message);
}

std::vector<ExportedMotion> Write(const core::PlanAnswer& answer, const PlanBody& body,
                                  std::optional<core::FileFormat> format = std::nullopt) {
  auto files = WriteMotions(answer, body, format, {});
  REQUIRE(files.ok());
  return *std::move(files);
}

TEST_CASE("DofNames: the name of the joint, with the axis if it has several",
          "[server][translate]") {
  CHECK(DofNames(*Arm()) ==
        Names{"base.tx", "base.rz", "elbow", "wrist.rz", "wrist.rx", "wrist.rz2"});
}

TEST_CASE("PlanMessage: the best plan, alternatives and the search", "[server][translate]") {
  core::PlanAnswer answer;
  answer.outcome = core::PlanOutcome::kDeadline;
  answer.missing = "time";
  answer.leg_length_m = 0.9;
  answer.effort = {1000, 3, false};
  answer.motions = {Motion(), Motion()};
  answer.motions[1].quality.smallest_clearance_m = -0.5;
  v1::PlanResponse message;
  Set(answer, message, {}, Write(answer, {}, core::FileFormat::kTrc));
  CHECK(message.outcome() == v1::PLAN_OUTCOME_DEADLINE);
  CHECK(message.missing() == "time");
  CHECK(message.leg_length_m() == 0.9);
  CHECK(message.effort().expansions() == 1000);
  CHECK(message.effort().improvements() == 3);
  const v1::PlannedMotion& motion = message.motion();
  CHECK(motion.outcome() == v1::PLAN_OUTCOME_APPROXIMATE);
  CHECK(motion.missing() == "a metre");
  REQUIRE(motion.segments_size() == 2);
  CHECK(motion.segments(0).clip() == "databases/db/clips/clip0");
  CHECK(motion.segments(0).start_seconds() == Approx(10 / 60.0));
  CHECK(motion.segments(1).clip() == "databases/db/clips/clip1");
  CHECK(motion.segments(1).start_seconds() == Approx(6 / 60.0));
  CHECK(motion.segments(1).end_seconds() == Approx(12 / 60.0));
  CHECK(motion.bottom_node_ids(1) == 4);
  CHECK(motion.frame_rate_hz() == 30);
  CHECK(motion.frame_count() == 2);
  CHECK(motion.root(1).y_m() == -0.25);
  CHECK(motion.marker_positions().size() == 2 * 3 * 4);
  CHECK(motion.quality().position_error_m() == 0.5);
  CHECK(motion.quality().foot_slide_m_per_s() == 0.02);
  CHECK(motion.quality().joint_limit_violations() == 7);
  CHECK(!motion.quality().has_smallest_clearance_m());
  CHECK(motion.dof_names_size() == 0);
  // Without a body, the file has the markers.
  CHECK(motion.file().file_name() == "plan.trc");
  REQUIRE(message.alternatives_size() == 1);
  CHECK(message.alternatives(0).quality().smallest_clearance_m() == -0.5);
}

TEST_CASE("PlanMessage: files have the names of their formats", "[server][translate]") {
  core::PlanAnswer answer;
  answer.motions = {Motion(), Motion()};
  PlanBody body{.skeleton = Arm()};
  for (core::PlannedMotion& motion : answer.motions) {
    motion.joints = core::JointMotion{body.skeleton, 30, core::JointMatrix::Constant(2, 6, 0.25)};
  }
  v1::PlanResponse bvh;
  Set(answer, bvh, body, Write(answer, body));
  CHECK(bvh.motion().dof_names_size() == 6);
  CHECK(bvh.motion().joint_angles().size() == 2 * 6 * 4);
  CHECK(Names(bvh.motion().joint_names().begin(), bvh.motion().joint_names().end()) ==
        Names{"base", "elbow", "plate", "wrist"});
  REQUIRE(bvh.motion().joint_bones_size() == 3);
  CHECK(bvh.motion().joint_bones(2).from_point() == 2);
  CHECK(bvh.motion().joint_bones(2).to_point() == 3);
  CHECK(bvh.motion().joint_positions().size() == 2 * 4 * 3 * 4);
  CHECK(bvh.motion().file().file_name() == "plan.bvh");
  CHECK(bvh.motion().file().data().starts_with("HIERARCHY"));
  CHECK(bvh.alternatives(0).file().file_name() == "plan-2.bvh");
  body.is_robot = true;
  v1::PlanResponse csv;
  Set(answer, csv, body, Write(answer, body));
  CHECK(csv.alternatives(0).file().file_name() == "plan-2.csv");
  CHECK(csv.motion().file().data().starts_with("time_s,"));
  v1::PlanResponse bare;
  Set(answer, bare, body);
  CHECK(!bare.motion().has_file());
}

TEST_CASE("PlanMessage: visual shapes of a robot, with the rotations of its joints",
          "[server][translate]") {
  core::PlanAnswer answer;
  answer.motions = {Motion()};
  PlanBody body{.skeleton = Arm(), .is_robot = true};
  // The elbow turns about x: 0.5 rad in both frames. The base turns about another axis.
  core::JointMatrix angles = core::JointMatrix::Zero(2, 6);
  angles.col(2).setConstant(0.5);
  answer.motions[0].joints = core::JointMotion{body.skeleton, 30, angles};
  v1::PlanResponse plain;
  Set(answer, plain, body);
  CHECK(plain.motion().joint_visuals().empty());
  CHECK(plain.motion().joint_rotations().empty());
  core::LinkVisual cylinder{
      .joint = 1, .geometry = core::LinkVisual::Geometry::kCylinder, .size_m = {0.25, 0.25, 1.5}};
  cylinder.joint_from_shape.translation() = Eigen::Vector3d(1, 2, 3);
  core::LinkVisual red = cylinder;
  red.color = Eigen::Vector4d(1, 0.25, 0, 0.5);
  body.visuals = {cylinder, red};
  v1::PlanResponse drawn;
  Set(answer, drawn, body);
  REQUIRE(drawn.motion().joint_visuals_size() == 2);
  const v1::LinkVisual& visual = drawn.motion().joint_visuals(0);
  const auto floats = [](const auto& values) {
    return std::vector<float>(values.begin(), values.end());
  };
  CHECK(visual.joint() == 1);
  CHECK(visual.geometry() == v1::VISUAL_GEOMETRY_CYLINDER);
  CHECK(floats(visual.size_m()) == std::vector<float>{0.25, 0.25, 1.5});
  CHECK(floats(visual.position_m()) == std::vector<float>{1, 2, 3});
  CHECK(floats(visual.rotation()) == std::vector<float>{0, 0, 0, 1});
  CHECK(visual.color().empty());
  CHECK(floats(drawn.motion().joint_visuals(1).color()) == std::vector<float>{1, 0.25, 0, 0.5});
  const std::vector<float> rotations = tests::Unpack(drawn.motion().joint_rotations());
  REQUIRE(rotations.size() == 2 * 4 * 4);
  for (const std::size_t elbow : {4U, 20U}) {
    CHECK(rotations[elbow] == Approx(std::sin(0.25)).margin(1e-6));
    CHECK(rotations[elbow + 3] == Approx(std::cos(0.25)).margin(1e-6));
  }
}

TEST_CASE("PlanMessage: joint limits, efforts and balance", "[server][translate]") {
  PlanBody body{.skeleton = Arm(), .is_robot = true};
  core::RobotDynamics dynamics;
  dynamics.max_efforts = Eigen::RowVectorXd::Constant(6, 20);
  dynamics.max_efforts[3] = std::numeric_limits<double>::infinity();
  body.dynamics = std::make_shared<core::RobotDynamics>(dynamics);
  core::PlanAnswer answer;
  answer.motions = {Motion()};
  core::PlannedMotion& motion = answer.motions[0];
  motion.joints = core::JointMotion{body.skeleton, 30, core::JointMatrix::Constant(2, 6, 0.25)};
  motion.slowed = {{0.5, 0.75, {2, core::LimitKind::kSpeed}, 1.5},
                   {1, 1.25, {5, core::LimitKind::kAcceleration}, 3}};
  motion.forces = core::RobotForces{{{2, 25, 0.5}, {3, 1, 0}}, core::Balance{-0.25, 0.5, 1, 2}};
  motion.quality.rate_violations = {4, 5};
  motion.quality.recorded_seconds = 6;
  motion.quality.unknown = core::UnlikeStored{0.25, 1.5};
  v1::PlanResponse message;
  Set(answer, message, body);
  const v1::PlannedMotion& planned = message.motion();
  CHECK(planned.quality().joint_speed_violations() == 4);
  CHECK(planned.quality().joint_acceleration_violations() == 5);
  CHECK(planned.quality().stored_duration_seconds() == 6);
  CHECK(planned.quality().unknown_probability() == 0.25);
  CHECK(planned.quality().unknown_at_seconds() == 1.5);
  REQUIRE(planned.slowed_parts_size() == 2);
  CHECK(planned.slowed_parts(0).dof_name() == "elbow");
  CHECK(planned.slowed_parts(0).limit() == v1::JOINT_LIMIT_SPEED);
  CHECK(planned.slowed_parts(0).start_seconds() == 0.5);
  CHECK(planned.slowed_parts(0).end_seconds() == 0.75);
  CHECK(planned.slowed_parts(0).factor() == 1.5);
  CHECK(planned.slowed_parts(1).dof_name() == "wrist.rz2");
  CHECK(planned.slowed_parts(1).limit() == v1::JOINT_LIMIT_ACCELERATION);
  REQUIRE(planned.joint_efforts_size() == 2);
  CHECK(planned.joint_efforts(0).dof_name() == "elbow");
  CHECK(planned.joint_efforts(0).peak_effort() == 25);
  CHECK(planned.joint_efforts(0).at_seconds() == 0.5);
  CHECK(planned.joint_efforts(0).effort_limit() == 20);
  CHECK_FALSE(planned.joint_efforts(1).has_effort_limit());
  CHECK(planned.balance().smallest_margin_m() == -0.25);
  CHECK(planned.balance().at_seconds() == 0.5);
  CHECK(planned.balance().outside_seconds() == 1);
  CHECK(planned.balance().supported_seconds() == 2);
}

TEST_CASE("WriteMotions: a cancelled call writes no files", "[server][translate]") {
  core::PlanAnswer answer;
  answer.motions = {Motion()};
  CHECK(absl::IsCancelled(WriteMotions(answer, {}, std::nullopt, [] { return true; }).status()));
}

}  // namespace
}  // namespace motiondb::server::plan_message_test
