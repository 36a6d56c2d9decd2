// Small files that would need gigabytes or hours in a careless reader.
#include <fmt/format.h>

#include "core/format/motion_file.h"
#include "core/format/urdf_reader.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests::reader_limits_test {
namespace {

constexpr int kMany = core::kMaxFileJoints;

std::string Motion(int channels) {
  std::string text = "MOTION\nFrames: 1\nFrame Time: 0.01\n";
  for (int c = 0; c < channels; ++c) text += "0 ";
  return text + "\n";
}

TEST_CASE("BVH: a body of only heads and feet takes linear time", "[core][format][hostile]") {
  // A chain, so that the path from each head to each foot has many bones.
  std::string text = "HIERARCHY\n";
  for (int j = 0; j < kMany; ++j) {
    text += fmt::format("{} {}{}\n{{\nOFFSET 0 1 0\nCHANNELS {}\n", j == 0 ? "ROOT" : "JOINT",
                        j % 2 == 0 ? "Head" : "LeftFoot", j, j == 0 ? "1 Xrotation" : "0");
  }
  text.append(kMany, '}');
  text += "\n" + Motion(1);
  const auto file = ReadText(core::FileFormat::kBvh, text);
  REQUIRE(Joints(file).skeleton->joint_count() == kMany);
}

// A root with joints and end sites, one per line.
std::string Comb(int joints, int ends) {
  std::string text = "HIERARCHY\nROOT r { OFFSET 0 0 0 CHANNELS 1 Xrotation\n";
  for (int j = 1; j < joints; ++j) text += fmt::format("JOINT j{} {{ OFFSET 0 1 0 }}\n", j);
  for (int e = 0; e < ends; ++e) text += "End Site { OFFSET 0 1 0 }\n";
  return text + "}\n" + Motion(1);
}

TEST_CASE("BVH: more joints than a skeleton may have", "[core][format][hostile]") {
  const auto refusal = [](int joints, int ends) {
    return ErrorMessageOf(ReadText(core::FileFormat::kBvh, Comb(joints, ends)));
  };
  CHECK(Joints(ReadText(core::FileFormat::kBvh, Comb(2000, 0))).skeleton->joint_count() == 2000);
  CHECK(Joints(ReadText(core::FileFormat::kBvh, Comb(1000, 1000))).skeleton->joint_count() == 2000);
  CHECK(refusal(2001, 0) ==
        "walk:2002: expected at most 2000 joints, found joint 'j2000' after them");
  CHECK_THAT(refusal(1000, 1001), Catch::StartsWith("walk:2002: expected at most 2000 joints"));
  CHECK_THAT(refusal(250'000, 0), Catch::StartsWith("walk:2002: expected at most 2000 joints"));
}

// An ASF with a root and bones, nine lines each from line 10 on: in a chain, or all on the root.
std::string Bones(int bones, bool chain) {
  std::string text =
      ":version 1.10\n:units\n mass 1\n length 1\n angle deg\n:root\n order TX TY TZ RX RY RZ\n"
      ":bonedata\n";
  for (int b = 1; b <= bones; ++b) {
    text += fmt::format(
        "begin\nid {0}\nname b{0}\ndirection 0 1 0\nlength 1\naxis 0 0 0 XYZ\nend\n", b);
  }
  text += ":hierarchy\nbegin\n";
  for (int b = 1; b <= bones; ++b) {
    text += (b == 1 || !chain ? std::string("root") : fmt::format("b{}", b - 1)) +
            fmt::format(" b{}\n", b);
  }
  return text + "end\n";
}

TEST_CASE("ASF: more joints than a skeleton may have", "[core][format][hostile]") {
  const auto read = [](const std::string& asf) {
    return core::ReadMotionFile(core::FileFormat::kAmc,
                                {.name = "walk", .bytes = ":DEGREES\n1\nroot 0 0 0 0 0 0\n"},
                                core::SourceFile{.name = "body", .bytes = asf});
  };
  // The root, the bones and the tip of the last one.
  CHECK(Joints(read(Bones(1998, true))).skeleton->joint_count() == 2000);
  CHECK_THAT(ErrorMessageOf(read(Bones(1999, true))),
             Catch::Contains("expected at most 2000 joints, found 2000 bones that end in 1 tips"));
  CHECK_THAT(
      ErrorMessageOf(read(Bones(1000, false))),
      Catch::Contains("expected at most 2000 joints, found 1001 bones that end in 1000 tips"));
  CHECK(ErrorMessageOf(read(Bones(2000, true))) ==
        "body:14008: expected at most 2000 joints, found bone 'b2000' after them");
}

// One joint per line.
std::string Links(int joints) {
  std::string text = "<robot><link name='l0'/>\n";
  for (int j = 1; j <= joints; ++j) {
    text += fmt::format(
        "<link name='l{0}'/><joint name='j{0}' type='fixed'><parent link='l{1}'/>"
        "<child link='l{0}'/></joint>\n",
        j, j - 1);
  }
  return text + "</robot>\n";
}

TEST_CASE("ReadUrdf: more joints than a skeleton may have", "[core][format][hostile]") {
  const auto read = [](const std::string& text) {
    return core::ReadUrdf({.name = "robot.urdf", .bytes = text});
  };
  const auto robot = read(Links(1999));
  REQUIRE(robot.ok());
  CHECK(robot->skeleton.joint_count() == 2000);
  CHECK(ErrorMessageOf(read(Links(2000))) ==
        "robot.urdf:2001: expected at most 1999 joints, found joint 'j2000' after them");
}

TEST_CASE("BVH: a long name is cut, not copied to every end site", "[core][format][hostile]") {
  const std::string name(100'000, 'n');
  std::string text = "HIERARCHY\nROOT " + name + "\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int end = 1; end < kMany; ++end) text += "End Site {\nOFFSET 0 1 0\n}\n";
  text += "}\n" + Motion(1);
  const auto file = ReadText(core::FileFormat::kBvh, text);
  std::size_t longest = 0;
  for (const core::Joint& joint : Joints(file).skeleton->joints()) {
    longest = std::max(longest, joint.name.size());
  }
  CHECK(longest < 300);
  // Names are not cut within a character.
  std::string umlauts;
  for (int i = 0; i < 200; ++i) umlauts += "\xC3\xA4";
  const auto cut = ReadText(
      core::FileFormat::kBvh,
      "HIERARCHY\nROOT " + umlauts + "\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\n" + Motion(1));
  CHECK(Joints(cut).skeleton->joints()[0].name == umlauts.substr(0, 254));
}

}  // namespace
}  // namespace motiondb::tests::reader_limits_test
