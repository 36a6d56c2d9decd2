// Written files are read back by the project's reader; joint positions must be preserved.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/export/writers.h"
#include "core/format/motion_file.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::bvh_writer_test {
namespace {

using Catch::Contains;
using core::Dof;
using core::Joint;
using core::JointMotion;
using Eigen::AngleAxisd;
using Eigen::Vector3d;

constexpr core::ReadOptions kWritten = {.metres_per_unit = 0.01, .up_axis = core::UpAxis::kY};

Dof Turn(const Vector3d& axis) { return {.kind = Dof::Kind::kRotation, .axis = axis}; }
Dof Slide(const Vector3d& axis) { return {.kind = Dof::Kind::kTranslation, .axis = axis}; }

JointMotion Motion(std::vector<Joint> joints, int frames) {
  auto skeleton = core::Skeleton::Create("figure", std::move(joints));
  REQUIRE(skeleton.ok());
  const int dofs = skeleton->dof_count();
  return {std::make_shared<core::Skeleton>(*std::move(skeleton)), 120,
          core::JointMatrix::Zero(frames, dofs)};
}

// Joints with their own axes, oblique axes, a slider and a fixed joint, and names that the format
// does not allow.
JointMotion OddFigure(int frames) {
  const Eigen::Matrix3d c = AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  JointMotion motion = Motion(
      {{.name = "the root",
        .offset_m = {0.1, 0.2, 0.9},
        .pre_rotation = c,
        .dofs = {Slide(Vector3d::UnitZ()), Turn(Vector3d::UnitZ()), Turn(Vector3d::UnitX())}},
       {.name = "arm",
        .parent = 0,
        .offset_m = {0.3, 0, 0},
        .pre_rotation = c,
        .post_rotation = c.transpose(),
        .dofs = {Turn(Vector3d::UnitX()), Turn(Vector3d::UnitY()), Turn(Vector3d::UnitX())}},
       {.name = "leg",
        .parent = 0,
        .offset_m = {0, 0, -0.4},
        .dofs = {Turn(Vector3d(1, 1, 0).normalized())}},
       {.name = "bracket", .parent = 1, .offset_m = {0.2, 0, 0}, .pre_rotation = c},
       {.name = "slider",
        .parent = 3,
        .offset_m = {0.1, 0, 0},
        .dofs = {Slide(Vector3d(0, 3, 4) / 5), Turn(Vector3d::UnitY())}},
       {.name = "leg_end", .parent = 2, .offset_m = {0, 0.1, -0.4}},
       {.name = "slider_end", .parent = 4, .offset_m = {0.1, 0, 0}},
       {.name = "gauge{}", .parent = 4, .offset_m = {0, 0.1, 0}}},
      frames);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-3, 3);
  for (Eigen::Index i = 0; i < motion.angles.size(); ++i) motion.angles.data()[i] = angle(random);
  return motion;
}

JointMotion WriteAndRead(const JointMotion& motion, const core::ReadOptions& options = kWritten) {
  const auto text = core::WriteBvh(motion);
  INFO(MessageOf(text.status()));
  REQUIRE(text.ok());
  return Joints(ReadText(core::FileFormat::kBvh, *text, options));
}

// Returns the maximum distance between joints of `motion` and the joints of the same name in
// `read`, m.
double MaxJointDistance(const JointMotion& motion, const JointMotion& read) {
  REQUIRE(read.angles.rows() == motion.angles.rows());
  double max_distance = 0;
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    const auto a = core::ForwardKinematics(*motion.skeleton, motion.angles.row(frame));
    const auto b = core::ForwardKinematics(*read.skeleton, read.angles.row(frame));
    for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
      const int at = read.skeleton->FindJoint(motion.skeleton->joints()[j].name);
      REQUIRE(at >= 0);
      max_distance = std::max(max_distance, (a[j].translation() - b[at].translation()).norm());
    }
  }
  return max_distance;
}

core::MotionFile ReadPath(const std::filesystem::path& path, const std::filesystem::path& asf) {
  const std::string bytes = ReadFile(path);
  const std::string asf_bytes = asf.empty() ? "" : ReadFile(asf);
  const auto format = core::FormatOfPath(path.string());
  REQUIRE(format.ok());
  auto file = core::ReadMotionFile(
      *format, {.name = "motion", .bytes = bytes},
      asf.empty() ? std::nullopt
                  : std::optional(core::SourceFile{.name = "skeleton", .bytes = asf_bytes}));
  REQUIRE(file.ok());
  return *std::move(file);
}

}  // namespace

TEST_CASE("WriteBvh: exact text of a small figure", "[core][format]") {
  JointMotion motion =
      Motion({{.name = "Hips",
               .dofs = {Slide(Vector3d::UnitX()), Slide(Vector3d::UnitY()),
                        Slide(Vector3d::UnitZ()), Turn(Vector3d::UnitZ())}},
              {.name = "Knee", .parent = 0, .offset_m = {0, 0, -0.5}, .dofs = {}},
              {.name = "Knee_end", .parent = 1, .offset_m = {0, 0, -0.25}, .dofs = {}}},
             1);
  motion.angles << 1, 2, 3, std::numbers::pi / 2;
  const auto text = core::WriteBvh(motion);
  REQUIRE(text.ok());
  // World z is the file's y, and world y its -z. The root rotates from the world's axes to the
  // file's.
  CHECK(*text ==
        "HIERARCHY\n"
        "ROOT Hips\n"
        "{\n"
        "\tOFFSET 0.00000000 0.00000000 0.00000000\n"
        "\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
        "\tJOINT Knee\n"
        "\t{\n"
        "\t\tOFFSET 0.00000000 0.00000000 -50.00000000\n"
        "\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n"
        "\t\tEnd Site\n"
        "\t\t{\n"
        "\t\t\tOFFSET 0.00000000 0.00000000 -25.00000000\n"
        "\t\t}\n"
        "\t}\n"
        "}\n"
        "MOTION\n"
        "Frames: 1\n"
        "Frame Time: 0.008333333333\n"
        "100.00000000 300.00000000 -200.00000000 90.00000000 0.00000000 90.00000000 "
        "0.00000000 0.00000000 0.00000000\n");
}

TEST_CASE("WriteBvh: joint positions of an unusual figure are preserved", "[core][format]") {
  JointMotion motion = OddFigure(50);
  JointMotion read = WriteAndRead(motion);
  CHECK(read.frame_rate_hz == 120);
  // Names were made valid: "the root", "gauge{}".
  CHECK(read.skeleton->FindJoint("the_root") == 0);
  CHECK(read.skeleton->FindJoint("gauge__") > 0);
  std::vector<Joint> joints = motion.skeleton->joints();
  joints[0].name = "the_root";
  joints[7].name = "gauge__";
  motion.skeleton =
      std::make_shared<core::Skeleton>(*core::Skeleton::Create("safe", std::move(joints)));
  CHECK(MaxJointDistance(motion, read) < 1e-8);
}

TEST_CASE("WriteBvh: end sites", "[core][format]") {
  const auto text = core::WriteBvh(OddFigure(1));
  REQUIRE(text.ok());
  // The end of the leg is its end site. The slider has two children, so its end is a joint, which
  // needs an end site like the gauge.
  CHECK_THAT(*text, !Contains("leg_end") && Contains("JOINT slider_end"));
  std::size_t sites = 0;
  for (std::size_t at = text->find("End Site"); at != text->npos; ++sites) {
    at = text->find("End Site", at + 1);
  }
  CHECK(sites == 3);
}

TEST_CASE("WriteBvh: angles are continuous through full turns", "[core][format]") {
  constexpr int kFrames = 361;
  const Vector3d axis = GENERATE(Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0, 1, 0));
  JointMotion motion = Motion({{.name = "a", .dofs = {}},
                               {.name = "b", .parent = 0, .offset_m = {1, 0, 0}},
                               {.name = "c", .parent = 1, .offset_m = {1, 1, 1}}},
                              1);
  std::vector<Joint> joints = motion.skeleton->joints();
  joints[1].dofs = {Turn(axis)};
  motion = Motion(std::move(joints), kFrames);
  for (int frame = 0; frame < kFrames; ++frame) motion.angles(frame, 0) = 0.05 * frame;
  const JointMotion read = WriteAndRead(motion);
  CHECK(MaxJointDistance(motion, read) < 1e-8);
  const int first = read.skeleton->first_dof(read.skeleton->FindJoint("b"));
  const auto angles = read.angles.middleCols(first, 3);
  CHECK((angles.bottomRows(kFrames - 1) - angles.topRows(kFrames - 1)).cwiseAbs().maxCoeff() <
        0.05 + 1e-6);
  CHECK((angles.row(kFrames - 1) - angles.row(0)).norm() == Approx(0.05 * (kFrames - 1)));
}

TEST_CASE("WriteBvh: refuses invalid motion", "[core][format]") {
  const auto refusal = [](const JointMotion& motion) {
    const auto text = core::WriteBvh(motion);
    REQUIRE_FALSE(text.ok());
    CHECK(text.status().code() == absl::StatusCode::kInvalidArgument);
    return MessageOf(text.status());
  };
  const JointMotion good = OddFigure(3);
  JointMotion bad = good;
  bad.skeleton = nullptr;
  CHECK_THAT(refusal(bad), Contains("no skeleton"));
  bad = good;
  bad.angles.conservativeResize(3, 2);
  CHECK_THAT(refusal(bad), Contains("found 2"));
  bad = good;
  bad.angles.conservativeResize(0, good.angles.cols());
  CHECK_THAT(refusal(bad), Contains("no frame"));
  for (const double rate : {0.0, -1.0, std::nan(""), 1e9}) {
    bad = good;
    bad.frame_rate_hz = rate;
    CHECK_THAT(refusal(bad), Contains("frame rate"));
  }
  bad = good;
  bad.angles(2, 1) = std::numeric_limits<double>::infinity();
  CHECK_THAT(refusal(bad), Contains("frame 2"));
}

TEST_CASE("WriteBvh: a chain of 20,000 joints does not overflow the stack", "[core][format]") {
  const auto written = [](int count) {
    std::vector<Joint> joints(count);
    for (int j = 0; j < count; ++j) {
      joints[j] = {.name = "j" + std::to_string(j), .parent = j - 1, .offset_m = {0, 0, 0.001}};
    }
    return core::WriteBvh(Motion(std::move(joints), 1));
  };
  CHECK(written(20'000).ok());
  // The longest chain that readers accept, including its end.
  const auto text = written(core::kMaxFileJoints - 1);
  REQUIRE(text.ok());
  CHECK(ReadText(core::FileFormat::kBvh, *text, kWritten).ok());
}

TEST_CASE("WriteBvh: real ASF and BVH motion is preserved, without notes", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  struct Source {
    const char* motion;
    const char* skeleton;
  };
  for (const Source& source :
       {Source{"cmu/02/02_01.amc", "cmu/02/02.asf"}, Source{"cmu/49/49_02.amc", "cmu/49/49.asf"},
        Source{"formats/same-motion/02_01.motionbuilder.bvh", ""},
        Source{"formats/same-motion/02_01.iclone.bvh", ""}, Source{"formats/other/131_01.bvh", ""},
        Source{"formats/other/fair_wave_hello.bvh", ""}}) {
    CAPTURE(source.motion);
    const auto file =
        ReadPath(DataDir() / source.motion,
                 *source.skeleton ? DataDir() / source.skeleton : std::filesystem::path());
    JointMotion motion = std::get<JointMotion>(file.motion);
    std::vector<Joint> joints = motion.skeleton->joints();
    const JointMotion read = WriteAndRead(motion, {});
    CHECK(read.frame_rate_hz == Approx(motion.frame_rate_hz));
    CHECK(MaxJointDistance(motion, read) < 1e-7);
  }
}

}  // namespace motiondb::tests::bvh_writer_test
