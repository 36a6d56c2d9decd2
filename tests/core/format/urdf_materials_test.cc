// The colours of a robot's visual shapes.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/format/urdf_elements.h"
#include "tests/core/format/odd_robot.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::urdf_materials_test {
namespace {

using Catch::Contains;
using core::UrdfRobot;
using Eigen::Vector4d;

// A <visual> with a ball and a material.
std::string Ball(std::string_view material) {
  return fmt::format("<visual><geometry><sphere radius='1'/></geometry>{}</visual>", material);
}

// A robot of one link. The materials are before the link.
UrdfRobot RobotOf(const std::string& visuals, const std::string& materials = "") {
  return GoodRobot("<robot>" + materials + "<link name='a'>" + visuals + "</link></robot>");
}

constexpr char kRed[] = "<material name='red'><color rgba='1 0.25 0 0.5'/></material>";

}  // namespace

TEST_CASE("UrdfMaterials: a colour in the visual, by name, or none", "[core][format]") {
  const UrdfRobot robot =
      RobotOf(Ball(kRed) + Ball("") + Ball("<material name='blue'/>") +
                  Ball("<material><color rgba=' 0 1\n0  1 '/></material>") + Ball("<material/>") +
                  Ball("<material name='unknown'/>") +
                  Ball("<material name='wood'><texture filename='wood.png'/></material>"),
              "<material name='blue'><color rgba='0 0 1 1'/></material>"
              "<material name='wood'><texture filename='other.png'/></material>");
  REQUIRE(robot.visuals.size() == 7);
  CHECK(robot.visuals[0].color == Vector4d(1, 0.25, 0, 0.5));
  CHECK_FALSE(robot.visuals[1].color);
  CHECK(robot.visuals[2].color == Vector4d(0, 0, 1, 1));
  CHECK(robot.visuals[3].color == Vector4d(0, 1, 0, 1));
  for (const int none : {4, 5, 6}) CHECK_FALSE(robot.visuals[none].color);
  CHECK_THAT(core::Describe(robot.report), !Contains("visual"));
}

TEST_CASE("UrdfMaterials: a name is looked up in the robot, then in other visuals",
          "[core][format]") {
  const std::string red = "<material name='red'/>";
  const std::string dark = "<material name='red'><color rgba='0.5 0 0 1'/></material>";
  SECTION("the visual that has the colour is later in the file") {
    CHECK(RobotOf(Ball(red) + Ball(kRed) + Ball(dark)).visuals[0].color ==
          Vector4d(1, 0.25, 0, 0.5));
  }
  SECTION("the robot's material counts more than that of another visual") {
    CHECK(RobotOf(Ball(kRed) + Ball(red), dark).visuals[1].color == Vector4d(0.5, 0, 0, 1));
  }
  SECTION("a visual keeps its own colour") {
    CHECK(RobotOf(Ball(kRed), dark).visuals[0].color == Vector4d(1, 0.25, 0, 0.5));
  }
}

TEST_CASE("UrdfMaterials: an invalid colour leaves out the shapes of its link, with a note",
          "[core][format]") {
  const std::vector<std::pair<std::string, const char*>> invalid = {
      {"<color/>", "expected <color> to have rgba, found none"},
      {"<color rgba='1 0 0'/>", "expected 4 finite numbers as rgba of <color>, found '1 0 0'"},
      {"<color rgba='1 0 0 1 1'/>", "4 finite numbers as rgba of <color>"},
      {"<color rgba='red'/>", "found 'red'"},
      {"<color rgba='nan 0 0 1'/>", "4 finite numbers as rgba of <color>"},
      {"<color rgba='255 0 0 1'/>", "expected rgba of <color> from 0 to 1, found 255 0 0 1"},
      {"<color rgba='0 -0.1 0 1'/>", "from 0 to 1, found 0 -0.1 0 1"},
      {"<color rgba='0 0 0 1.5'/>", "from 0 to 1"},
  };
  for (const auto& [color, reason] : invalid) {
    CAPTURE(color);
    const std::string material = "\n<material name='m'>" + color + "</material>";
    const UrdfRobot own = RobotOf(Ball("") + Ball(material));
    CHECK(own.visuals.empty());
    CHECK_THAT(
        core::Describe(own.report),
        Contains("visual shapes of 1 link are left out: robot.urdf:2: ") && Contains(reason));
    // The line is that of the definition. Without a shape that uses it, it does not matter.
    CHECK_THAT(core::Describe(RobotOf(Ball("<material name='m'/>"), material).report),
               Contains("robot.urdf:2: ") && Contains(reason));
    CHECK(RobotOf(Ball(""), material).visuals.size() == 1);
  }
}

TEST_CASE("UrdfMaterials: the colours of a real robot", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const UrdfRobot robot = GoodRobot(ReadFile(DataDir() / "robots" / "h1.urdf"));
  REQUIRE_FALSE(robot.visuals.empty());
  for (const core::LinkVisual& visual : robot.visuals) CHECK(visual.color);
}

}  // namespace motiondb::tests::urdf_materials_test
