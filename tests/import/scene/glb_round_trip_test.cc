// Motion that motiondb writes as GLB comes back with its frames and frame rate.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/export/motion_writer.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/export/odd_skeleton.h"
#include "tests/import/imported.h"
#include "tests/import/scene/scene_files.h"

namespace motiondb::tests::glb_round_trip_test {
namespace {

using core::FileFormat;

absl::StatusOr<core::MotionFile> ReadWritten(const std::string& bytes) {
  return ReadSceneBytes(FileFormat::kGltf, bytes);
}

void CheckRoundTrip(int frames, double rate_hz) {
  CAPTURE(frames, rate_hz);
  const core::JointMotion motion = RandomMotion(OddJoints(), frames, rate_hz, 3);
  const auto written = core::WriteMotion(FileFormat::kGltf, motion);
  REQUIRE(written.ok());
  const auto read = ReadWritten(written->bytes);
  const core::JointMotion& back = Joints(read);
  CHECK(back.frame_rate_hz == rate_hz);
  REQUIRE(back.angles.rows() == frames);
  const core::FrameMatrix before = core::JointPositions(motion);
  const core::FrameMatrix after = core::JointPositions(back);
  for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
    const int k = back.skeleton->FindJoint(motion.skeleton->joints()[j].name);
    if (k < 0) continue;  // a root above all that moves
    CHECK((after.middleCols<3>(3 * k) - before.middleCols<3>(3 * j)).cwiseAbs().maxCoeff() < 1e-3F);
  }
}

}  // namespace

TEST_CASE("GLB round trip: single frames and any frame rate", "[import][scene]") {
  for (const double rate_hz : {0.01, 0.5, 1.0, 5.0, 9.99, 10.0, 29.97, 30.0, 60.1, 1000.0}) {
    for (const int frames : {1, 2, 3, 40}) CheckRoundTrip(frames, rate_hz);
  }
}

TEST_CASE("GLB round trip: the last frame of a long take is not lost", "[import][scene]") {
  const core::JointMotion motion =
      RandomMotion({{.name = "root", .offset_m = {0, 0, 1}},
                    {.name = "arm", .parent = 0, .offset_m = {0, 1, 0}}},
                   300'000, 120.0, 1);
  const auto written = core::WriteMotion(FileFormat::kGltf, motion);
  REQUIRE(written.ok());
  const auto read = ReadWritten(written->bytes);
  CHECK(Joints(read).angles.rows() == 300'000);
}

TEST_CASE("GLB round trip: a stated rate below that of the keys is not used", "[import][scene]") {
  GltfFile file = NoddingFigure(10);
  file.json["asset"]["extras"]["frame_rate_hz"] = 2;
  const auto read = ReadWritten(file.Text());
  CHECK(Joints(read).frame_rate_hz == 30);
  for (const nlohmann::json& odd : {nlohmann::json(0), nlohmann::json(-1), nlohmann::json(1e300),
                                    nlohmann::json("30"), nlohmann::json(nullptr)}) {
    file.json["asset"]["extras"]["frame_rate_hz"] = odd;
    CHECK(Joints(ReadWritten(file.Text())).frame_rate_hz == 30);
  }
}

}  // namespace motiondb::tests::glb_round_trip_test
