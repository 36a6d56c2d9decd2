// The visual shapes of a robot's links.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <numbers>

#include "core/format/urdf_elements.h"
#include "tests/core/format/odd_robot.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::urdf_visuals_test {
namespace {

using Catch::Contains;
using core::LinkVisual;
using core::UrdfRobot;
using Eigen::Vector3d;
using VisualKind = LinkVisual::Geometry;

// A <visual> of a geometry, with an optional origin.
std::string Visual(std::string_view geometry, std::string_view origin = "") {
  return fmt::format("<visual>{}<geometry>{}</geometry></visual>", origin, geometry);
}

// kRobot with visuals in its links `upper` and `tip`.
std::string RobotWith(const std::string& upper, const std::string& tip = "") {
  const auto link = [](const char* name, const std::string& content) {
    return fmt::format("<link name=\"{}\">{}</link>", name, content);
  };
  const std::string text =
      Replaced(std::string(kRobot), "<link name=\"upper\"/>", link("upper", upper));
  return Replaced(text, "<link name=\"tip\"/>", link("tip", tip));
}

std::string NotesOf(const UrdfRobot& robot) { return core::Describe(robot.report); }

}  // namespace

TEST_CASE("ReadUrdf: boxes, cylinders and spheres in the frames of their joints",
          "[core][format]") {
  const UrdfRobot robot = GoodRobot(RobotWith(
      Visual("<box size=\"0.1 0.2 0.3\"/>",
             "<origin xyz=\"1 -2 3\" rpy=\"0 0 1.5707963267948966\"/>") +
          Visual("<cylinder radius=\"0.05\" length=\"0.4\"/>", "<origin xyz=\"0 0 0.2\"/>"),
      "<collision/>" + Visual("<sphere radius=\"0.25\"/>")));
  REQUIRE(robot.visuals.size() == 3);
  const LinkVisual& box = robot.visuals[0];
  const LinkVisual& cylinder = robot.visuals[1];
  const LinkVisual& sphere = robot.visuals[2];
  // The joint that moves a link has the link's frame.
  CHECK(box.joint == robot.skeleton.FindJoint("shoulder"));
  CHECK(cylinder.joint == box.joint);
  CHECK(sphere.joint == robot.skeleton.FindJoint("tip_joint"));
  CHECK(box.geometry == VisualKind::kBox);
  CHECK(box.size_m == Vector3d(0.1, 0.2, 0.3));
  // Rz(90 deg) takes the corner (0.05, 0.1, 0.15) to (-0.1, 0.05, 0.15).
  CHECK((box.joint_from_shape * Vector3d(0.05, 0.1, 0.15) - Vector3d(0.9, -1.95, 3.15)).norm() <
        1e-12);
  CHECK(cylinder.geometry == VisualKind::kCylinder);
  CHECK(cylinder.size_m == Vector3d(0.1, 0.1, 0.4));
  CHECK(cylinder.joint_from_shape.translation() == Vector3d(0, 0, 0.2));
  CHECK(sphere.geometry == VisualKind::kSphere);
  CHECK(sphere.size_m == Vector3d(0.5, 0.5, 0.5));
  CHECK(sphere.joint_from_shape.matrix().isIdentity());
  CHECK_THAT(NotesOf(robot), !Contains("visual"));
}

TEST_CASE("ReadUrdf: the base has the shapes of its link, the world has none", "[core][format]") {
  const std::string ball = Visual("<sphere radius='1'/>");
  const UrdfRobot plain = GoodRobot("<robot><link name='a'>" + ball + "</link></robot>");
  REQUIRE(plain.visuals.size() == 1);
  CHECK(plain.visuals[0].joint == 0);
  const UrdfRobot floating = GoodRobot(
      "<robot><link name='world'>" + Visual("<box size='9 9 1'/>") + "</link><link name='a'>" +
      ball +
      "</link><joint name='free' type='floating'><parent link='world'/><child link='a'/></joint>"
      "</robot>");
  REQUIRE(floating.visuals.size() == 1);
  CHECK(floating.visuals[0].geometry == VisualKind::kSphere);
  CHECK(floating.visuals[0].joint == 0);
}

TEST_CASE("ReadUrdf: a link with a mesh has no shapes, without a note", "[core][format]") {
  const std::string ball = Visual("<sphere radius=\"1\"/>");
  for (const std::string& other :
       {Visual("<mesh filename=\"package://a.dae\"/>"), Visual("<capsule radius=\"1\"/>"),
        Visual(""), std::string("<visual/>")}) {
    CAPTURE(other);
    for (const std::string& upper : {ball + other, other + ball}) {
      const UrdfRobot robot = GoodRobot(RobotWith(upper, ball));
      REQUIRE(robot.visuals.size() == 1);
      CHECK(robot.visuals[0].joint == robot.skeleton.FindJoint("tip_joint"));
      CHECK_THAT(NotesOf(robot), !Contains("visual"));
    }
  }
}

TEST_CASE("ReadUrdf: a link with an invalid shape has none, and a note has the reason",
          "[core][format]") {
  const std::string ball = Visual("<sphere radius=\"1\"/>");
  const std::array<std::pair<std::string, const char*>, 14> invalid = {{
      {Visual("<box/>"), "expected a box with sizes above 0 and at most 100 m, found 0 x 0 x 0"},
      {Visual("<box size=\"1 1\"/>"), "expected 3 finite numbers as size of <box>, found '1 1'"},
      {Visual("<box size=\"1 nan 1\"/>"), "3 finite numbers as size of <box>"},
      {Visual("<box size=\"1 inf 1\"/>"), "3 finite numbers as size of <box>"},
      {Visual("<box size=\"1 0 1\"/>"), "sizes above 0"},
      {Visual("<box size=\"1 -1 1\"/>"), "sizes above 0"},
      {Visual("<box size=\"1 1 101\"/>"), "at most 100 m, found 1 x 1 x 101 m"},
      {Visual("<cylinder radius=\"1\"/>"), "found 2 x 2 x 0 m"},
      {Visual("<cylinder length=\"1\"/>"), "found 0 x 0 x 1 m"},
      {Visual("<cylinder radius=\"1e17\" length=\"1\"/>"), "at most 100 m"},
      {Visual("<sphere radius=\"-1\"/>"), "expected a sphere with sizes above 0"},
      {Visual("<sphere radius=\"1e999\"/>"), "1 finite number as radius of <sphere>"},
      {Visual("<sphere radius=\"1\"/>", "<origin xyz=\"0 0 101\"/>"),
       "expected a shape at most 100 m from its link"},
      {Visual("<sphere radius=\"1\"/>", "<origin rpy=\"nan 0 0\"/>"),
       "3 finite numbers as rpy of <origin>"},
  }};
  for (const auto& [visual, reason] : invalid) {
    CAPTURE(visual);
    const UrdfRobot robot = GoodRobot(RobotWith(ball + visual, ball));
    REQUIRE(robot.visuals.size() == 1);
    CHECK(robot.visuals[0].joint == robot.skeleton.FindJoint("tip_joint"));
    CHECK_THAT(NotesOf(robot), Contains("visual shapes of 1 link are left out: robot.urdf:18:") &&
                                   Contains(reason));
  }
  const std::string bad = Visual("<box/>");
  CHECK_THAT(NotesOf(GoodRobot(RobotWith(bad, bad))), Contains("visual shapes of 2 links"));
}

TEST_CASE("ReadUrdf: the number of shapes is limited", "[core][format]") {
  const std::string ball = Visual("<sphere radius=\"1\"/>");
  const auto balls = [&](std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += ball;
    return text;
  };
  const UrdfRobot full = GoodRobot(RobotWith(balls(600), balls(400)));
  CHECK(full.visuals.size() == core::kMaxVisuals);
  CHECK_THAT(NotesOf(full), !Contains("visual"));
  // All of a link or nothing.
  const UrdfRobot more = GoodRobot(RobotWith(balls(600), balls(401)));
  CHECK(more.visuals.size() == 600);
  CHECK_THAT(NotesOf(more), Contains("expected at most 1000 visual shapes"));
  CHECK(GoodRobot(RobotWith(balls(50'000))).visuals.empty());
}

TEST_CASE("ReadUrdf: the shapes of robots of several makers", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  // Other links have meshes, which may include spheres as contact points.
  const std::map<std::string, std::size_t> robots = {
      {"atlas_minimal_contact", 4}, {"g1_29dof_rev_1_0", 0}, {"h1", 3}, {"simple_humanoid", 0}};
  for (const auto& [name, count] : robots) {
    CAPTURE(name);
    const UrdfRobot robot = GoodRobot(ReadFile(DataDir() / "robots" / (name + ".urdf")));
    CHECK(robot.visuals.size() == count);
    CHECK_THAT(NotesOf(robot), !Contains("visual"));
  }
}

}  // namespace motiondb::tests::urdf_visuals_test
