// Files of some kilobytes that would take gigabytes or hours if their readers were not careful.
#include <fmt/format.h>

#include "tests/core/format/reading.h"

namespace motiondb::tests {
namespace {

constexpr int kMany = 20'000;

std::string Motion(int channels) {
  std::string text = "MOTION\nFrames: 1\nFrame Time: 0.01\n";
  for (int c = 0; c < channels; ++c) text += "0 ";
  return text + "\n";
}

TEST_CASE("BVH: a body of heads and feet alone takes time in proportion",
          "[core][format][hostile]") {
  // A chain, so that the way from each head to each foot leads over many bones.
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

TEST_CASE("BVH: a long name is cut, not copied to every end site", "[core][format][hostile]") {
  const std::string name(100'000, 'n');
  std::string text = "HIERARCHY\nROOT " + name + "\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int end = 0; end < kMany; ++end) text += "End Site {\nOFFSET 0 1 0\n}\n";
  text += "}\n" + Motion(1);
  const auto file = ReadText(core::FileFormat::kBvh, text);
  std::size_t longest = 0;
  for (const core::Joint& joint : Joints(file).skeleton->joints()) {
    longest = std::max(longest, joint.name.size());
  }
  CHECK(longest < 300);
  // A name is not cut within a character.
  std::string umlauts;
  for (int i = 0; i < 200; ++i) umlauts += "\xC3\xA4";
  const auto cut = ReadText(
      core::FileFormat::kBvh,
      "HIERARCHY\nROOT " + umlauts + "\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\n" + Motion(1));
  CHECK(Joints(cut).skeleton->joints()[0].name == umlauts.substr(0, 254));
}

}  // namespace
}  // namespace motiondb::tests
