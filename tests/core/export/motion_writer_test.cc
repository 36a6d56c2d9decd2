#include "core/export/motion_writer.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <variant>

#include "core/format/motion_file.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/export/odd_skeleton.h"

namespace motiondb::tests::motion_writer_test {
namespace {

using core::FileFormat;

core::MarkerMotion TwoMarkers() {
  core::MarkerMotion motion{{"a", "a_end"}, 50, core::FrameMatrix(5, 6)};
  for (int frame = 0; frame < 5; ++frame) {
    for (int column = 0; column < 6; ++column) {
      motion.positions_m(frame, column) = static_cast<float>(frame + 10 * column);
    }
  }
  return motion;
}

// Writes and reads back a format that core reads.
core::Motion Back(FileFormat format, const std::string& bytes) {
  const std::string name = "back" + std::string(core::WrittenExtension(format));
  core::ReadOptions options;
  if (format == FileFormat::kBvh || format == FileFormat::kTrc) {
    options.up_axis = core::UpAxis::kY;
  }
  if (format == FileFormat::kBvh) options.metres_per_unit = 0.01;
  auto read = core::ReadMotionFile(format, {name, bytes}, {}, options);
  INFO(read.status());
  REQUIRE(read.ok());
  return std::move(read->motion);
}

TEST_CASE("WriteMotion: markers keep their positions in every format", "[core][export]") {
  const core::MarkerMotion markers = TwoMarkers();
  for (const auto format : {FileFormat::kTrc, FileFormat::kC3d, FileFormat::kCsv}) {
    CAPTURE(core::InfoOf(format).name);
    const auto written = core::WriteMotion(format, markers);
    REQUIRE(written.ok());
    CHECK(written->losses.empty());
    const auto back = std::get<core::MarkerMotion>(Back(format, written->bytes));
    CHECK(back.names == markers.names);
    CHECK((back.positions_m - markers.positions_m).cwiseAbs().maxCoeff() < 1e-4F);
  }
  const auto bvh = core::WriteMotion(FileFormat::kBvh, markers);
  REQUIRE(bvh.ok());
  CHECK(bvh->losses.empty());
  const auto joints = std::get<core::JointMotion>(Back(FileFormat::kBvh, bvh->bytes));
  const core::MarkerMotion back = core::JointsAsMarkers(joints);
  for (std::size_t i = 0; i < markers.names.size(); ++i) {
    const int joint = joints.skeleton->FindJoint(markers.names[i]);
    REQUIRE(joint >= 0);
    const auto at = static_cast<Eigen::Index>(3 * i);
    CHECK((back.positions_m.middleCols(3 * joint, 3) - markers.positions_m.middleCols(at, 3))
              .cwiseAbs()
              .maxCoeff() < 1e-4F);
  }
}

TEST_CASE("WriteMotion: gaps are filled in a format of joints, and reported", "[core][export]") {
  constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
  core::MarkerMotion markers = TwoMarkers();
  for (const int frame : {0, 2, 3}) markers.positions_m.row(frame).head<3>().setConstant(kMissing);
  const auto written = core::WriteMotion(FileFormat::kBvh, markers);
  REQUIRE(written.ok());
  REQUIRE(written->losses.size() == 1);
  CHECK(written->losses[0] == "gaps: 3 positions are filled");
  const auto joints = std::get<core::JointMotion>(Back(FileFormat::kBvh, written->bytes));
  const int joint = joints.skeleton->FindJoint("a");
  const core::FrameMatrix positions = core::JointPositions(joints);
  // Linear between frames 1 and 4; the first frame gets the nearest.
  const std::array<float, 5> expected = {1, 1, 2, 3, 4};
  for (int frame = 0; frame < 5; ++frame) {
    CHECK(positions(frame, 3 * joint) == Approx(expected[frame]).margin(1e-4));
  }
  markers.positions_m.leftCols<3>().setConstant(kMissing);
  const auto without = core::WriteMotion(FileFormat::kGltf, markers);
  REQUIRE(without.ok());
  CHECK(without->losses[0] == "markers without a position: a");
  markers.positions_m.setConstant(kMissing);
  CHECK(core::WriteMotion(FileFormat::kBvh, markers).status().code() ==
        absl::StatusCode::kInvalidArgument);
}

TEST_CASE("WriteMotion: joints become points where the format has no joints", "[core][export]") {
  const core::JointMotion motion = RandomMotion(OddJoints(), 12, 50, 1.5);
  const core::MarkerMotion expected = core::JointsAsMarkers(motion);
  for (const auto format : {FileFormat::kTrc, FileFormat::kC3d, FileFormat::kCsv}) {
    CAPTURE(core::InfoOf(format).name);
    const auto written = core::WriteMotion(format, motion);
    REQUIRE(written.ok());
    REQUIRE(written->losses.size() == 1);
    CHECK_THAT(written->losses[0], Catch::StartsWith("hierarchy and joint rotations"));
    const auto back = std::get<core::MarkerMotion>(Back(format, written->bytes));
    REQUIRE(back.positions_m.rows() == expected.positions_m.rows());
    CHECK((back.positions_m - expected.positions_m).cwiseAbs().maxCoeff() < 1e-4F);
  }
}

TEST_CASE("WriteMotion: formats that are read only, and invalid motion", "[core][export]") {
  const core::MarkerMotion markers = TwoMarkers();
  for (const core::FormatInfo& info : core::KnownFormats()) {
    CAPTURE(info.name);
    CHECK(core::WriteMotion(info.format, markers).ok() == info.is_written);
    core::MarkerMotion invalid = markers;
    invalid.frame_rate_hz = 0;
    CHECK(!core::WriteMotion(info.format, invalid).ok());
    CHECK(!core::WriteMotion(info.format, core::JointMotion{}).ok());
  }
}

}  // namespace
}  // namespace motiondb::tests::motion_writer_test
