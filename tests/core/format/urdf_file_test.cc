// URDF files that are corrupt, hostile or not URDF.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "tests/core/format/odd_robot.h"

namespace motiondb::tests::urdf_file_test {

using Catch::Contains;
using core::UrdfRobot;

TEST_CASE("ReadUrdf: missing or invalid parts are reported with their line", "[core][format]") {
  CHECK_THAT(ErrorMessageWith("name=\"elbow\" type", "type"),
             Contains("robot.urdf:5: expected <joint> to have a name, found none"));
  CHECK_THAT(ErrorMessageWith("<link name=\"tip\"/>", "<link/>"),
             Contains("<link> to have a name"));
  CHECK_THAT(ErrorMessageWith("<link name=\"tip\"/>", "<link name=\"\"/>"), Contains("a name"));
  CHECK_THAT(ErrorMessageWith(" type=\"planar\"", ""), Contains("<joint> to have a type"));
  CHECK_THAT(ErrorMessageWith("planar", "screw"), Contains("floating or planar, found 'screw'"));
  CHECK_THAT(ErrorMessageWith("<parent link=\"upper\"/>", ""), Contains("<parent link=...>"));
  CHECK_THAT(ErrorMessageWith("<parent link=\"upper\"/>", "<parent/>"),
             Contains("<parent> to have"));
  CHECK_THAT(ErrorMessageWith("xyz=\"0 2 0\"", "xyz=\"0 0 0\""),
             Contains("robot.urdf:9: joint 'elbow': expected a nonzero axis"));
  CHECK_THAT(
      ErrorMessageWith("<limit lower=\"-0.5\" upper=\"2\" effort=\"1\" velocity=\"1\"/>", ""),
      Contains("joint 'elbow': expected <limit>"));
  CHECK_THAT(ErrorMessageWith("lower=\"-0.5\"", "lower=\"2.5\""),
             Contains("expected lower <= upper"));
  for (const char* numbers : {"nan 0 1", "inf 0 1", "1e999 0 1", "0 0", "0 0 0 0", "", "0,0,0",
                              "a b c", "${x} 0 0", "0x1 0 0"}) {
    CHECK_THAT(ErrorMessageWith("xyz=\"0 0 -0.3\"", fmt::format("xyz=\"{}\"", numbers)),
               Contains("robot.urdf:8: expected 3 finite numbers as xyz of <origin>"));
    CHECK_THAT(
        ErrorMessageWith("rpy=\"0 0 1.5707963267948966\"", fmt::format("rpy=\"{}\"", numbers)),
        Contains("expected 3 finite numbers as rpy"));
  }
  CHECK_THAT(ErrorMessageWith("lower=\"-0.5\"", "lower=\"low\""),
             Contains("expected 1 finite number as lower of <limit>, found 'low'"));
}

TEST_CASE("ReadUrdf: negative or invalid speeds, efforts and masses are refused",
          "[core][format]") {
  const char* limit = "<limit lower=\"-0.5\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
  CHECK_THAT(ErrorMessageWith(limit, "<limit upper=\"2\" velocity=\"-1\"/>"),
             Contains("robot.urdf:10: joint 'elbow': expected velocity >= 0, found -1"));
  CHECK_THAT(ErrorMessageWith(limit, "<limit upper=\"2\" effort=\"-3\"/>"),
             Contains("joint 'elbow': expected effort >= 0, found -3"));
  CHECK_THAT(ErrorMessageWith(limit, "<limit upper=\"2\" velocity=\"nan\"/>"),
             Contains("expected 1 finite number as velocity of <limit>, found 'nan'"));
  CHECK_THAT(ErrorMessageWith("<mass value=\"1\"/>", "<mass value=\"-2\"/>"),
             Contains("mass of link 'base': expected value >= 0, found -2"));
  CHECK_THAT(ErrorMessageWith("<mass value=\"1\"/>", "<inertia ixx=\"one\"/>"),
             Contains("expected 1 finite number as ixx of <inertia>, found 'one'"));
  CHECK_THAT(ErrorMessageWith("<mass value=\"1\"/>", "<origin xyz=\"0 0\"/>"),
             Contains("expected 3 finite numbers as xyz of <origin>"));
}

TEST_CASE("ReadUrdf: other files are refused", "[core][format]") {
  for (const char* text : {"", "   \n", "hello", "HIERARCHY\nROOT Hips\n{\n", "<", "<robot",
                           "<robot/", "<robot/><", "<robot/>x", "x<robot/>", "<robot/><robot/>",
                           "<sdf><model/></sdf>", "<!-- no -->", "<robot><link name='a'></robot>",
                           "<robot><link name='a' name='b'/></robot>", "\xff\xfe<\x01"}) {
    CAPTURE(text);
    CHECK_THAT(ErrorMessageOf(ReadRobot(text)), Contains("robot.urdf") && Contains("expected"));
  }
  CHECK_THAT(ErrorMessageOf(ReadRobot("<mujoco/>")), Contains("expected <robot>, found <mujoco>"));
  CHECK_THAT(ErrorMessageOf(ReadRobot(std::string_view("<robot/>\0<", 10))), Contains("zero byte"));
  CHECK_THAT(ErrorMessageOf(ReadRobot("<robot xmlns:xacro='x'>\n<xacro:arg name='a'/></robot>")),
             Contains("robot.urdf:2: expected URDF, found <xacro:arg>"));
}

TEST_CASE("ReadUrdf: every truncation is refused", "[core][format]") {
  CheckEveryTruncation(
      kRobot, [](std::string_view text) { return ReadRobot(text); },
      [](std::size_t length) { return length + 1 >= kRobot.size(); });  // except the last line end
}

TEST_CASE("ReadUrdf: entities of a document type are refused, not expanded", "[core][format]") {
  std::string bomb = "<?xml version='1.0'?>\n<!DOCTYPE robot [\n<!ENTITY e0 'boom'>\n";
  for (int i = 1; i < 30; ++i) {
    bomb += fmt::format("<!ENTITY e{} '&e{};&e{};'>\n", i, i - 1, i - 1);
  }
  bomb += "]>\n<robot name='&e29;'><link name='&e29;'/></robot>";
  CHECK_THAT(ErrorMessageOf(ReadRobot(bomb)), Contains("robot.urdf:2: expected no document type"));
  CHECK_THAT(ErrorMessageOf(ReadRobot("<!DOCTYPE r [<!ENTITY x SYSTEM 'file:///etc/hostname'>]>"
                                      "<robot><link name='&x;'/></robot>")),
             Contains("expected no document type"));
  CHECK(GoodRobot("<robot><link name='&amp;&lt;&#65;'/></robot>").skeleton.joints()[0].name ==
        "&<A");
}

TEST_CASE("ReadUrdf: every file takes little time, memory and stack", "[core][format]") {
  const auto repeated = [](std::string_view part, std::size_t bytes) {
    std::string text;
    while (text.size() < bytes) text += part;
    return text;
  };
  constexpr std::size_t kJustUnder = (4 << 20) - 100;
  CHECK_THAT(ErrorMessageOf(ReadRobot(repeated("<a>", 100 << 20))),
             Contains("at most 4194304 bytes"));
  CHECK_THAT(ErrorMessageOf(ReadRobot(repeated("<a>", kJustUnder))), Contains("DEPTH"));
  CHECK_THAT(ErrorMessageOf(ReadRobot("<robot>" + repeated("<a/>", kJustUnder) + "</robot>")),
             Contains("at least one <link>"));
  // Attributes of one tag, which the parser compares pairwise; quotes may contain a '>'.
  std::string attributes = "<robot>\n<link";
  for (int i = 0; attributes.size() < kJustUnder; ++i) attributes += fmt::format(" a{}='>'", i);
  CHECK_THAT(ErrorMessageOf(ReadRobot(attributes + "/></robot>")),
             Contains("robot.urdf:2: expected a tag"));
  // Long comments are not tags.
  CHECK(ReadRobot("<robot><!--" + repeated(" a='", 1 << 20) + "--><link name='a'/></robot>").ok());
  // A chain of mimic joints, last first.
  std::string mimics = "<robot><link name='l0'/>";
  for (int i = 1999; i > 0; --i) {
    mimics += fmt::format(
        "<link name='l{0}'/><joint name='j{0}' type='continuous'><parent link='l{1}'/>"
        "<child link='l{0}'/>",
        i, i - 1);
    if (i > 1) mimics += fmt::format("<mimic joint='j{}'/>", i - 1);
    mimics += "</joint>";
  }
  const UrdfRobot robot = GoodRobot(mimics + "</robot>");
  CHECK(robot.mimics.size() == 1998);
  CHECK(robot.mimics.back().master == "j1");
}

TEST_CASE("ReadUrdf: names that are not UTF-8, and any line ends", "[core][format]") {
  const UrdfRobot robot = GoodRobot(
      "<robot><link name='H\xfc"
      "fte'/></robot>");
  CHECK(robot.skeleton.joints()[0].name ==
        "H\xc3\xbc"
        "fte");
  CHECK(GoodRobot(WithLineEnds(kRobot, "\r\n")).skeleton.joint_count() == 9);
  CHECK(GoodRobot("\xef\xbb\xbf" + std::string(kRobot)).skeleton.joint_count() == 9);
}

}  // namespace motiondb::tests::urdf_file_test
