#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests::amc_reader_test {
namespace {

using Catch::Contains;
using core::Dof;
using core::Provenance;
using core::ReadOptions;
using core::SourceFile;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kUnit = 0.0254 / 0.5;

// A spine of two bones and a bent arm, with all sections and comments that files have.
constexpr std::string_view kAsf = R"(#!OML:ASF made by hand
:version 1.10
:name figure
:units
  mass 1.0
  length 0.5
  angle deg
:documentation
   Free text, with numbers: 1 2 3
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name spine
     direction 0 2 0
     length 10
     axis 0 0 0 XYZ
     bodymass 3
     dof rx ry rz
     limits (-160.0 20.0)
            (-70 70)
            (-inf inf)
  end
  begin
     id 2
     name head
     direction 0 1 0
     length 4
     axis 0 0 0 XYZ
  end
  begin # the arm
     id 3
     name arm
     direction 1 0 0
     length 6
     axis 90 30 -20 ZXY
     dof rz rx
     limits (20 -45)
            (-70 70)
  end
:hierarchy
  begin
    root spine
    spine head arm
  end
:skin
  anything.obj
)";

constexpr std::string_view kAmc = R"(#!OML:ASF X:\made\by\hand
:FULLY-SPECIFIED
:DEGREES
1
root 1 20 3 10 20 30
spine 40 50 60
arm 70 -80
2
root 1 21 3 10 20 30
spine 40 50 60
arm 70 8
)";

absl::StatusOr<core::MotionFile> ReadAmc(std::string_view amc, std::string_view asf = kAsf,
                                         const ReadOptions& options = {}) {
  return core::ReadMotionFile(core::FileFormat::kAmc, {.name = "walk", .bytes = amc},
                              SourceFile{.name = "figure", .bytes = asf}, options);
}

std::string Amc(std::string_view from, std::string_view to) {
  return Replaced(std::string(kAmc), from, to);
}

std::string Asf(std::string_view from, std::string_view to) {
  return Replaced(std::string(kAsf), from, to);
}

Matrix3d Rx(double degrees) {
  return AngleAxisd(degrees * kRadians, Vector3d::UnitX()).toRotationMatrix();
}
Matrix3d Ry(double degrees) {
  return AngleAxisd(degrees * kRadians, Vector3d::UnitY()).toRotationMatrix();
}
Matrix3d Rz(double degrees) {
  return AngleAxisd(degrees * kRadians, Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

TEST_CASE("AMC: joints, units and report", "[core][format]") {
  const auto file = ReadAmc(kAmc);
  const core::JointMotion& motion = Joints(file);
  const core::Skeleton& skeleton = *motion.skeleton;
  CHECK(skeleton.name() == "figure");
  REQUIRE(skeleton.joint_count() == 6);
  for (const char* name : {"root", "spine", "head", "arm", "head_end", "arm_end"}) {
    CHECK(skeleton.FindJoint(name) >= 0);
  }
  CHECK(skeleton.dof_count() == 6 + 3 + 2);
  CHECK(motion.angles.rows() == 2);
  CHECK(motion.frame_rate_hz == 120);
  CHECK(core::Describe(file->report) ==
        "unit 0.0508 m (stated), y up (stated); frame rate 120 Hz assumed (the file states none)");
}

TEST_CASE("AMC: poses equal matrices multiplied by hand", "[core][format]") {
  const auto file = ReadAmc(kAmc);
  const core::JointMotion& motion = Joints(file);
  const auto pose = core::ForwardKinematics(*motion.skeleton, motion.angles.row(0));
  // In the file's axes. Listed x y z: x is applied first.
  const Matrix3d root = Rz(30) * Ry(20) * Rx(10);
  const Matrix3d spine = root * Rz(60) * Ry(50) * Rx(40);
  // axis 90 30 -20 ZXY: about z first; dof rz rx: about z first.
  const Matrix3d c = Ry(-20) * Rx(30) * Rz(90);
  const Matrix3d arm = spine * c * Rx(-80) * Rz(70) * c.transpose();
  const Vector3d root_at(1, 20, 3);
  const Vector3d spine_tip = root_at + spine * Vector3d(0, 10, 0);  // normalized direction
  const auto near = [&](const char* joint, const Vector3d& in_file) {
    const Vector3d world = kUnit * Vector3d(in_file.x(), -in_file.z(), in_file.y());
    return (pose[motion.skeleton->FindJoint(joint)].translation() - world).norm() < 1e-12;
  };
  CHECK(near("root", root_at));
  CHECK(near("spine", root_at));
  CHECK(near("head", spine_tip));
  CHECK(near("head_end", spine_tip + spine * Vector3d(0, 4, 0)));
  CHECK(near("arm", spine_tip));
  CHECK(near("arm_end", spine_tip + arm * Vector3d(6, 0, 0)));
}

TEST_CASE("AMC: limits follow their degrees of freedom", "[core][format]") {
  const auto file = ReadAmc(kAmc);
  const core::Skeleton& skeleton = *Joints(file).skeleton;
  const auto& spine = skeleton.joints()[skeleton.FindJoint("spine")].dofs;
  REQUIRE(spine.size() == 3);
  CHECK(spine[0].axis == Vector3d::UnitZ());
  CHECK(std::isinf(spine[0].upper));
  CHECK(spine[2].axis == Vector3d::UnitX());
  CHECK(spine[2].lower == Approx(-160 * kRadians));
  const auto& arm = skeleton.joints()[skeleton.FindJoint("arm")].dofs;
  CHECK(arm[1].axis == Vector3d::UnitZ());
  CHECK(arm[1].lower == Approx(-45 * kRadians));  // swapped: the file has them in the wrong order
  CHECK(arm[1].upper == Approx(20 * kRadians));
}

TEST_CASE("AMC: degrees of freedom in any order, including translations and stretch",
          "[core][format]") {
  const auto file =
      ReadAmc(Amc("arm 70 -80", "arm 70 2 1.5 -80 "),
              Asf("dof rz rx\n     limits (20 -45)\n            (-70 70)", "dof RZ ty L rx"));
  CHECK_THAT(ErrorMessageOf(file), Contains("value 3 of 4 of bone 'arm' in frame 2"));
  const auto both =
      ReadAmc(Replaced(Amc("arm 70 -80", "arm 70 2 1.5 -80 "), "arm 70 8\n", "arm 70 2 1.5 8\n"),
              Asf("dof rz rx\n     limits (20 -45)\n            (-70 70)", "dof RZ ty L rx"));
  const core::JointMotion& motion = Joints(both);
  const int arm = motion.skeleton->FindJoint("arm");
  const auto& dofs = motion.skeleton->joints()[arm].dofs;
  REQUIRE(dofs.size() == 3);
  CHECK(dofs[0].kind == Dof::Kind::kTranslation);
  const Matrix3d c = Ry(-20) * Rx(30) * Rz(90);
  CHECK((dofs[0].axis - c.col(1)).norm() < 1e-12);
  const int first = motion.skeleton->first_dof(arm);
  CHECK(motion.angles(0, first) == Approx(2 * kUnit));
  CHECK(motion.angles(0, first + 1) == Approx(-80 * kRadians));
  CHECK(motion.angles(0, first + 2) == Approx(70 * kRadians));
  CHECK_THAT(core::Describe(both->report), Contains("bone length are ignored"));
}

TEST_CASE("AMC: the root's order, orientation and position", "[core][format]") {
  std::string amc(kAmc);
  for (const char* y : {"20", "21"}) {
    amc = Replaced(amc, fmt::format("root 1 {} 3 10 20 30", y), "root 30 1 20 3 20 10");
  }
  std::string asf = Asf("order TX TY TZ RX RY RZ", "order RZ TX TY TZ RY RX");
  asf = Replaced(asf, "position 0 0 0", "position 5 6 7");
  asf = Replaced(asf, "orientation 0 0 0", "orientation 15 25 35");
  asf = Replaced(asf, "axis XYZ", "axis YZX");
  const auto file = ReadAmc(amc, asf);
  const core::JointMotion& motion = Joints(file);
  const auto pose = core::ForwardKinematics(*motion.skeleton, motion.angles.row(0));
  const Matrix3d c = Rx(35) * Rz(25) * Ry(15);
  const Matrix3d world_from_root = Rx(90) * c * Rx(10) * Ry(20) * Rz(30) * c.transpose();
  CHECK((pose[0].linear() - world_from_root).norm() < 1e-12);
  CHECK((pose[0].translation() - kUnit * (Rx(90) * Vector3d(6, 26, 10))).norm() < 1e-12);
}

TEST_CASE("AMC: radians, rate and frame numbers", "[core][format]") {
  const auto radians = ReadAmc(Amc(":DEGREES", ":RADIANS\n:SAMPLES-PER-SECOND 60"));
  CHECK(Joints(radians).angles(0, 3) == 30);  // about z
  CHECK(Joints(radians).frame_rate_hz == 60);
  CHECK(radians->report.notes.empty());
  const auto by_asf = ReadAmc(Amc(":DEGREES\n", ""), Asf("angle deg", "angle rad"));
  CHECK(Joints(by_asf).angles(0, 3) == 30);
  const auto given =
      ReadAmc(kAmc, kAsf, {.metres_per_unit = 2, .up_axis = {}, .frame_rate_hz = 100});
  CHECK(Joints(given).frame_rate_hz == 100);
  CHECK(Joints(given).angles(0, 1) == 40);
  CHECK(given->report.unit_provenance == Provenance::kGiven);
  const auto late = ReadAmc(Replaced(Amc("\n1\n", "\n27\n"), "\n2\n", "\n28\n"));
  REQUIRE(late.ok());
  CHECK_THAT(core::Describe(late->report), Contains("frames start at 27"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("\n2\n", "\n4\n"))),
             Contains("walk:8: expected frame 2, found '4'"));
}

TEST_CASE("AMC: mixed line ends, and any bytes in comments", "[core][format]") {
  const auto expected = ReadAmc(kAmc);
  for (const char* line_end : {"\r\n", "\r", "\n\n"}) {
    const auto file = ReadAmc(WithLineEnds(kAmc, line_end), WithLineEnds(kAsf, line_end));
    CHECK(Joints(file).angles == Joints(expected).angles);
  }
  const auto mixed = ReadAmc(Replaced(Amc("hand\n", "\xFC\xE4\r\n"), "1\n", "1\r\n"));
  CHECK(Joints(mixed).angles == Joints(expected).angles);
}

TEST_CASE("AMC: bones may change their order", "[core][format]") {
  const auto file = ReadAmc(Amc("2\nroot 1 21 3 10 20 30\nspine 40 50 60\narm 70 8\n",
                                "2\narm 70 8\nspine 40 50 60\nhead\nroot 1 21 3 10 20 30\n"));
  CHECK(Joints(file).angles == Joints(ReadAmc(kAmc)).angles);
}

TEST_CASE("AMC: errors in frames name their line", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("spine 40 50 60\n", ""))),
             Contains("walk:7: expected bone 'spine' in frame 1, found '2'"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("arm 70 8\n", ""))),
             Contains("truncated") && Contains("expected bone 'arm' in frame 2"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("spine", "tail"))),
             Contains("walk:6: expected a bone of the skeleton in frame 1, found 'tail'"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("spine 40 50 60", "spine 40 50"))),
             Contains("walk:6: the line ends here, expected value 3 of 3 of bone 'spine'"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("spine 40 50 60", "spine 40 50 60 70"))),
             Contains("walk:6: expected 3 values of bone 'spine' in frame 1, found '70'"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("spine 40 50 60", "spine 40 nan 60"))),
             Contains("found 'nan'"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("arm 70 -80", "arm 70 -80\narm 70 -80"))),
             Contains("walk:8: expected bone 'arm' once in frame 1"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(Amc("1\nroot", "root"))),
             Contains("number of the first frame"));
  CHECK_THAT(ErrorMessageOf(ReadAmc(":FULLY-SPECIFIED\n")), Contains("number of the first frame"));
}

TEST_CASE("AMC: requires its skeleton", "[core][format]") {
  CHECK_THAT(ErrorMessageOf(ReadText(core::FileFormat::kAmc, kAmc)),
             Contains("expected an ASF file"));
}

TEST_CASE("ASF: inconsistencies are reported with their line", "[core][format]") {
  const auto refusal = [](std::string_view from, std::string_view to) {
    return ErrorMessageOf(ReadAmc(kAmc, Asf(from, to)));
  };
  CHECK_THAT(refusal("angle deg", "angle grad"), Contains("figure:7: expected 'deg' or 'rad'"));
  CHECK_THAT(refusal("length 0.5", "length 0"), Contains("figure:6: expected a length unit"));
  CHECK_THAT(refusal("order TX", "order TW"), Contains("figure:11: expected tx, ty"));
  CHECK_THAT(refusal("axis XYZ", "axis XXZ"), Contains("figure:12: expected an order of axes"));
  CHECK_THAT(refusal("direction 0 2 0", "direction 0 2"), Contains("(number 3 of 3)"));
  CHECK_THAT(refusal("length 10\n", "\n"), Contains("length of bone 'spine'"));
  CHECK_THAT(refusal("name head", "name spine"), Contains("found 'spine' twice"));
  CHECK_THAT(refusal("(-70 70)", "(-70 70"), Contains("expected ')'"));
  CHECK_THAT(refusal("dof rx ry rz", "dof rx rx rz"), Contains("'rx' twice"));
  CHECK_THAT(refusal("spine head arm", "spine head leg"), Contains("':bonedata', found 'leg'"));
  CHECK_THAT(refusal("spine head arm", "spine head"), Contains("expected bone 'arm'"));
  CHECK_THAT(refusal("spine head arm", "spine head arm\nhead arm"), Contains("one parent"));
  CHECK_THAT(refusal("root spine\n    spine head arm", "root head\n spine arm\n arm spine"),
             Contains("descend from the root"));
  CHECK_THAT(refusal(":hierarchy", ":skin"), Contains("expected a ':hierarchy' section"));
  CHECK_THAT(refusal("order TX TY TZ RX RY RZ", ""), Contains("':root' section with 'order'"));
  CHECK_THAT(refusal("  end\n  begin # the arm", "  begin"), Contains("expected 'end'"));
}

TEST_CASE("ASF: every truncation is refused with a message", "[core][format]") {
  const std::size_t complete = kAsf.find("  end\n:skin") + 5;
  CheckEveryTruncation(
      kAsf, [](std::string_view asf) { return ReadAmc(kAmc, asf); },
      [complete](std::size_t length) { return length >= complete; });
}

TEST_CASE("AMC: every truncation within a frame is refused with a message", "[core][format]") {
  const std::string amc = Amc("arm 70 -80", "arm 70 7");
  const std::size_t first = amc.find("\n2\n");
  const std::size_t last = amc.size() - 1;
  CheckEveryTruncation(
      amc, [](std::string_view text) { return ReadAmc(text); },
      [&](std::size_t length) { return length == first || length == first + 1 || length >= last; });
}

}  // namespace motiondb::tests::amc_reader_test
