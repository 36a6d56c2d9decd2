#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests::bvh_reader_test {
namespace {

using Catch::Contains;
using core::Dof;
using core::FileFormat;
using core::Provenance;
using core::ReadOptions;
using core::UpAxis;

constexpr double kRadians = std::numbers::pi / 180;

// A standing figure in cm, y up: feet at 0, head at 170.
constexpr std::string_view kFigure = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Head
  {
    OFFSET 0 60 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 20 0
    }
  }
  JOINT LeftFoot
  {
    OFFSET 10 -85 0
    CHANNELS 1 Xrotation
    End Site
    {
      OFFSET 0 -5 12
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.01
1 91 3 10 20 30 0 0 0 5
1 92 3 10 20 30 0 0 0 6
)";

absl::StatusOr<core::MotionFile> ReadBvh(std::string_view text, const ReadOptions& options = {}) {
  return ReadText(FileFormat::kBvh, text, options);
}

std::string Figure(std::string_view from, std::string_view to) {
  return Replaced(std::string(kFigure), from, to);
}

// Reads one joint with these channels and this frame, in metres and z up: unchanged.
absl::StatusOr<core::MotionFile> ReadOneJoint(std::string_view offset, std::string_view channels,
                                              std::string_view frame) {
  const std::string text = fmt::format(
      "HIERARCHY\nROOT a\n{{\nOFFSET {}\nCHANNELS {}\nEnd Site\n{{\nOFFSET 1 0 0\n}}\n}}\n"
      "MOTION\nFrames: 1\nFrame Time: 0.01\n{}\n",
      offset, channels, frame);
  return ReadBvh(text, {.metres_per_unit = 1, .up_axis = UpAxis::kZ, .frame_rate_hz = {}});
}

Eigen::Vector3f Position(const core::JointMotion& motion, std::string_view joint, int frame) {
  const int index = motion.skeleton->FindJoint(joint);
  REQUIRE(index >= 0);
  return core::JointPositions(motion).block<1, 3>(frame, 3 * index).transpose();
}

bool Near(const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return (a - b).norm() < 1e-5F; }

}  // namespace

TEST_CASE("BVH: a figure in centimetres, y up, becomes metres, z up", "[core][format]") {
  const auto file = ReadBvh(kFigure);
  const core::JointMotion& motion = Joints(file);
  CHECK(file->report.metres_per_unit == 0.01);
  CHECK(file->report.unit_provenance == Provenance::kDeduced);
  CHECK(file->report.up_axis == UpAxis::kY);
  CHECK(file->report.up_provenance == Provenance::kDeduced);
  CHECK(file->report.notes.empty());
  CHECK(motion.frame_rate_hz == 100);
  CHECK(motion.angles.rows() == 2);
  REQUIRE(motion.skeleton->joint_count() == 5);
  CHECK(motion.skeleton->joints()[2].name == "Head_end");
  CHECK(motion.skeleton->joints()[4].name == "LeftFoot_end");
  CHECK(motion.skeleton->joints()[4].dofs.empty());
  CHECK(motion.skeleton->dof_count() == 10);
  // Position channels replace the root's OFFSET: (1, 91, 3) cm, with y up.
  CHECK(Near(Position(motion, "Hips", 0), {0.01F, -0.03F, 0.91F}));
  CHECK(motion.angles(0, 3) == Approx(10 * kRadians));
  CHECK(motion.angles(1, 9) == Approx(6 * kRadians));
}

TEST_CASE("BVH: rotations apply in the order listed", "[core][format]") {
  const auto zx = ReadOneJoint("0 0 0", "2 Zrotation Xrotation", "90 90");
  CHECK(Near(Position(Joints(zx), "a_end", 0), {0, 1, 0}));
  // Rx Rz: x goes to y by Rz, then to z by Rx.
  const auto xz = ReadOneJoint("0 0 0", "2 Xrotation Zrotation", "90 90");
  CHECK(Near(Position(Joints(xz), "a_end", 0), {0, 0, 1}));
  const auto zxz = ReadOneJoint("0 0 0", "3 Zrotation Xrotation Zrotation", "90 0 90");
  CHECK(Near(Position(Joints(zxz), "a_end", 0), {-1, 0, 0}));
}

TEST_CASE("BVH: any channel count, and positions in any order", "[core][format]") {
  const auto mixed = ReadOneJoint("5 6 7", "4 Zrotation Yposition Xrotation Xposition", "90 2 0 1");
  const core::JointMotion& motion = Joints(mixed);
  CHECK(Near(Position(motion, "a", 0), {1, 2, 7}));  // z keeps its OFFSET
  CHECK(Near(Position(motion, "a_end", 0), {1, 3, 7}));
  REQUIRE(motion.skeleton->joints()[0].dofs.size() == 4);
  CHECK(motion.skeleton->joints()[0].dofs[0].kind == Dof::Kind::kTranslation);
  CHECK(motion.skeleton->joints()[0].offset_m == Eigen::Vector3d(5, 6, 7));
  const auto one = ReadOneJoint("0 0 0", "1 Yrotation", "90");
  CHECK(Near(Position(Joints(one), "a_end", 0), {0, 0, -1}));
  CHECK_THAT(ErrorMessageOf(ReadOneJoint("0 0 0", "7 Xrotation", "1")),
             Contains("walk:5: expected the"));
  CHECK_THAT(ErrorMessageOf(ReadOneJoint("0 0 0", "2 Xposition Xposition", "1 1")),
             Contains("once"));
  CHECK_THAT(ErrorMessageOf(ReadOneJoint("0 0 0", "1 Xscale", "1")),
             Contains("walk:5: expected channel 1 of 1 of joint 'a'"));
  CHECK_THAT(ErrorMessageOf(ReadOneJoint("0 0 0", "0", "")),
             Contains("at least one joint with channels"));
}

TEST_CASE("BVH: positions of inner joints replace their OFFSET too", "[core][format]") {
  const auto file = ReadBvh(
      "HIERARCHY ROOT a\n{ OFFSET 0 0 0 JOINT b\n{ OFFSET 1 2 3 CHANNELS 1 Xposition } }\n"
      "MOTION Frames: 1 Frame Time: 0.01\n7",
      {.metres_per_unit = 1, .up_axis = UpAxis::kZ, .frame_rate_hz = {}});
  CHECK(Joints(file).skeleton->joints()[0].dofs.empty());  // a root without channels
  CHECK(Near(Position(Joints(file), "b", 0), {7, 2, 3}));
  CHECK_THAT(core::Describe(file->report), Contains("does not end with a line end"));
}

TEST_CASE("BVH: letter case, spacing and braces do not matter", "[core][format]") {
  std::string text(kFigure);
  for (char& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c;
  CHECK(Joints(ReadBvh(text)).angles == Joints(ReadBvh(kFigure)).angles);
  for (const char* end :
       {"end site", "END  SITE", "EndSite", "End Site tip", "End Site {\n", "End"}) {
    CAPTURE(end);
    const bool brace = std::string_view(end).find('{') != std::string_view::npos;
    const auto file = ReadBvh(brace ? Figure("End Site\n    {", end) : Figure("End Site", end));
    CHECK(Joints(file).skeleton->FindJoint("Head_end") == 2);
  }
  CHECK(Joints(ReadBvh(Figure("JOINT Head\n  {", "JOINT Head {"))).skeleton->FindJoint("Head") ==
        1);
  CHECK(Joints(ReadBvh(Figure("Frames: 2\nFrame Time: 0.01", "FRAMES:2\nframe time :\t.01")))
            .frame_rate_hz == 100);
}

TEST_CASE("BVH: line ends, and the byte order mark, do not matter", "[core][format]") {
  const auto expected = ReadBvh(kFigure);
  for (const char* line_end : {"\r\n", "\r", "\r\r\n", "\n\n"}) {
    CHECK(Joints(ReadBvh(WithLineEnds(kFigure, line_end))).angles == Joints(expected).angles);
  }
  CHECK(Joints(ReadBvh("\xEF\xBB\xBF" + std::string(kFigure))).angles == Joints(expected).angles);
}

TEST_CASE("BVH: frames are a stream of numbers", "[core][format]") {
  const auto expected = ReadBvh(kFigure);
  CHECK(Joints(ReadBvh(Figure("0 5\n", "0 5 "))).angles == Joints(expected).angles);
  CHECK(Joints(ReadBvh(Figure("30 0 0 0 5", "30\n0 0 0\n5"))).angles == Joints(expected).angles);
}

TEST_CASE("BVH: names with spaces, invalid UTF-8 and duplicates", "[core][format]") {
  const auto file = ReadBvh(Figure("JOINT LeftFoot", "JOINT  Linker Fu\xDF ankle "));
  CHECK(Joints(file).skeleton->joints()[3].name == "Linker Fu\xC3\x9F ankle");
  const auto twice = ReadBvh(Figure("JOINT LeftFoot", "JOINT Head"));
  CHECK(Joints(twice).skeleton->joints()[3].name == "Head_2");
  CHECK_THAT(core::Describe(twice->report), Contains("made distinct: Head_2"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("JOINT Head", "JOINT"))),
             Contains("walk:6: ") && Contains("name"));
}

TEST_CASE("BVH: the unit is deduced from a person's size", "[core][format]") {
  struct Case {
    double factor;
    double unit;
  };
  for (const Case& c : {Case{0.01, 1}, Case{1, 0.01}, Case{10, 0.001}, Case{0.394, 0.0254},
                        Case{0.177, 0.0254 / 0.45}}) {
    const auto file = ReadBvh(fmt::format(
        "HIERARCHY\nROOT hip\n{{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\nJOINT head\n{{\nOFFSET 0 {} "
        "0\n"
        "}}\nJOINT ankle\n{{\nOFFSET 0 {} 0\n}}\n}}\nMOTION\nFrames: 1\nFrame Time: 1\n0\n",
        85 * c.factor, -85 * c.factor));
    REQUIRE(file.ok());
    CHECK(file->report.metres_per_unit == Approx(c.unit));
    CHECK(file->report.unit_provenance == Provenance::kDeduced);
  }
}

TEST_CASE("BVH: without a person, assumes cm and y up and reports it", "[core][format]") {
  const auto file = ReadBvh(
      "HIERARCHY\nROOT base\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\nMOTION\nFrames: 1\n"
      "Frame Time: 1\n0\n");
  REQUIRE(file.ok());
  CHECK(core::Describe(file->report) ==
        "unit 0.01 m (assumed), y up (assumed); no figure of a person: 0.01 m per unit assumed");
  const auto giant = ReadBvh(Figure("OFFSET 0 60 0", "OFFSET 0 400 0"));
  REQUIRE(giant.ok());
  CHECK(giant->report.unit_provenance == Provenance::kAssumed);
  CHECK_THAT(core::Describe(giant->report),
             Contains("fits no known unit: scaled to a stature of 1.7 m"));
}

TEST_CASE("BVH: the up axis points to the head in the motion, not in the zero pose",
          "[core][format]") {
  struct Case {
    const char* rotation;  // of a root whose zero pose is along y
    UpAxis up;
  };
  for (const Case& c : {Case{"0 0 0", UpAxis::kY}, Case{"0 90 0", UpAxis::kZ},
                        Case{"0 -90 0", UpAxis::kMinusZ}, Case{"90 0 0", UpAxis::kMinusX},
                        Case{"-90 0 0", UpAxis::kX}, Case{"180 0 0", UpAxis::kMinusY}}) {
    std::string text(kFigure);
    for (int i = 0; i < 2; ++i) text = Replaced(text, "10 20 30", c.rotation);
    const auto file = ReadBvh(text);
    CHECK(file->report.up_axis == c.up);
    const core::JointMotion& motion = Joints(file);
    CHECK(Position(motion, "Head", 0).z() - Position(motion, "LeftFoot", 0).z() > 1.4F);
  }
}

TEST_CASE("BVH: conventions of the caller override the file's", "[core][format]") {
  const auto file =
      ReadBvh(kFigure, {.metres_per_unit = 0.02, .up_axis = UpAxis::kZ, .frame_rate_hz = 50});
  CHECK(Near(Position(Joints(file), "Hips", 0), {0.02F, 1.82F, 0.06F}));
  CHECK(Joints(file).frame_rate_hz == 50);
  CHECK(file->report.unit_provenance == Provenance::kGiven);
  CHECK(file->report.up_provenance == Provenance::kGiven);
  CHECK_THAT(
      ErrorMessageOf(ReadBvh(kFigure, {.metres_per_unit = 0, .up_axis = {}, .frame_rate_hz = {}})),
      Contains("metres_per_unit"));
  CHECK_THAT(
      ErrorMessageOf(ReadBvh(kFigure, {.metres_per_unit = {}, .up_axis = {}, .frame_rate_hz = -1})),
      Contains("frame_rate_hz"));
}

TEST_CASE("BVH: a rounded frame time is mapped to the exact rate", "[core][format]") {
  struct Case {
    const char* time;
    double rate;
  };
  for (const Case& c :
       {Case{".0083333", 120}, Case{"0.008333", 120}, Case{"0.016667", 60}, Case{"0.033333", 30},
        Case{"0.0416667", 24}, Case{"0.041708", 24000.0 / 1001}, Case{"0.0333667", 30000.0 / 1001},
        Case{"0.0166833", 60000.0 / 1001}, Case{"0.03", 1 / 0.03}}) {
    const auto file = ReadBvh(Figure("0.01\n", fmt::format("{}\n", c.time)));
    CHECK(Joints(file).frame_rate_hz == Approx(c.rate).epsilon(1e-12));
  }
  const auto file = ReadBvh(Figure("0.01\n", ".008333\n"));
  REQUIRE(file.ok());
  CHECK_THAT(core::Describe(file->report), Contains("rate 120.0048 Hz taken for 120 Hz"));
}

TEST_CASE("BVH: invalid frame times and counts are refused", "[core][format]") {
  for (const char* time : {"0", "-0.01", "nan", "inf", "1e-9", "1e9", "abc", "0.01s"}) {
    CAPTURE(time);
    CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("0.01\n", fmt::format("{}\n", time)))),
               Contains("walk:27: expected") && Contains("frame time"));
  }
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("Frame Time: 0.01\n", ""))),
             Contains("walk:27: expected 'Frame Time:'"));
  for (const char* frames : {"0", "-1", "1.5", "many", "1e12"}) {
    CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("Frames: 2", fmt::format("Frames: {}", frames)))),
               Contains("walk:26: expected the number of frames"));
  }
}

TEST_CASE("BVH: missing and extra frames are reported", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("Frames: 2", "Frames: 3"))),
             Contains("truncated") && Contains("expected 3 frames, found 2"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("Frames: 2", "Frames: 2147483647"))),
             Contains("expected 2147483647 frames, found 2"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("0 0 0 6", "0 0 6"))),
             Contains("number 10 of 10 of frame 2"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(std::string(kFigure) + "7\n")),
             Contains("walk:30: expected the file to end after 2 frames, found '7'"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("CHANNELS 1 Xrotation", "CHANNELS 0"))),
             Contains("first line of frames has 10 numbers, the hierarchy 9 channels"));
  // One extra frame is ignored: some writers count from 0.
  const auto more = ReadBvh(Figure("Frames: 2", "Frames: 1"));
  CHECK(Joints(more).angles.rows() == 1);
  CHECK_THAT(core::Describe(more->report), Contains("one frame more than its 1 declared frames"));
}

TEST_CASE("BVH: a missing or extra number is reported with its line", "[core][format]") {
  const auto refusal = [](std::string_view lines, int frames) {
    return ErrorMessageOf(ReadBvh(Replaced(Figure("1 92 3 10 20 30 0 0 0 6\n", lines), "Frames: 2",
                                           fmt::format("Frames: {}", frames))));
  };
  const std::string whole = "1 92 3 10 20 30 0 0 0 6\n", less = "1 92 3 10 20 30 0 0 6\n";
  CHECK_THAT(refusal(less + whole + whole, 4),
             Contains("walk:29: the line ends here, expected number 10 of 10 of frame 2 of 4"));
  CHECK_THAT(refusal(whole + "1 2" + whole + whole, 4),
             Contains("walk:30: expected 10 numbers in frame 3 of 4, found '6' after them"));
  CHECK_THAT(refusal(less, 2), Contains("walk:29: the file ends here (truncated?)") &&
                                   Contains("number 10 of 10 of frame 2 of 2"));
  // The first line is wrong.
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("0 0 0 5", "0 0 5"))),
             Contains("walk:28: the line ends here, expected number 10 of 10 of frame 1 of 2"));
  // A line before an invalid number.
  CHECK_THAT(refusal(less + "1 x 3 10 20 30 0 0 0 6\n", 3),
             Contains("walk:29: the line ends here"));
}

TEST_CASE("BVH: an invalid number is reported with its position", "[core][format]") {
  for (const char* bad : {"1.2abc", "nan", "inf", "1,5", "1e400"}) {
    CHECK_THAT(
        ErrorMessageOf(ReadBvh(Figure("1 92 3", fmt::format("1 {} 3", bad)))),
        Contains(fmt::format("walk:29: expected number 2 of 10 of frame 2 of 2, found '{}'", bad)));
  }
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("OFFSET 0 60 0", "OFFSET 0 60"))),
             Contains("walk:8: the line ends here, expected a number (OFFSET has three)"));
}

TEST_CASE("BVH: an invalid hierarchy is refused", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadBvh("")), Contains("walk:1: ") && Contains("'HIERARCHY'"));
  CHECK_THAT(ErrorMessageOf(ReadBvh("HIERARCHY MOTION")), Contains("expected 'ROOT'"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("    OFFSET 0 60 0\n", ""))),
             Contains("expected 'OFFSET' in joint 'Head'"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("OFFSET 0 60 0", "OFFSET 0 60 0 OFFSET 0 0 0"))),
             Contains("found a second"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("}\nMOTION", "MOTION"))), Contains("found 'MOTION'"));
  CHECK_THAT(ErrorMessageOf(ReadBvh(Figure("}\nMOTION", "}\n}\nMOTION"))),
             Contains("expected 'MOTION'"));
}

TEST_CASE("BVH: very deep nesting is refused", "[core][format]") {
  std::string text = "HIERARCHY\nROOT a\n";
  for (int i = 0; i < 200000; ++i) text += "{ OFFSET 0 0 0 JOINT a\n";
  CHECK_THAT(ErrorMessageOf(ReadBvh(text)), Contains("walk:2002: expected at most 2000 joints"));
}

TEST_CASE("BVH: every truncation is refused with a message", "[core][format]") {
  const std::size_t complete = kFigure.size() - 1;  // without the last line end
  CheckEveryTruncation(
      kFigure, [](std::string_view text) { return ReadBvh(text); },
      [complete](std::size_t length) { return length >= complete; });
}

}  // namespace motiondb::tests::bvh_reader_test
