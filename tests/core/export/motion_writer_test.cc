#include "core/export/motion_writer.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <variant>
#include <vector>

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
    REQUIRE(!written->losses.empty());
    CHECK_THAT(written->losses[0], Catch::StartsWith("hierarchy and joint rotations"));
    const auto back = std::get<core::MarkerMotion>(Back(format, written->bytes));
    REQUIRE(back.positions_m.rows() == expected.positions_m.rows());
    CHECK((back.positions_m - expected.positions_m).cwiseAbs().maxCoeff() < 1e-4F);
  }
}

// Names with everything that a format may change.
core::MarkerMotion OddlyNamedMarkers() {
  core::MarkerMotion motion{{" left arm ", "left\tarm", "points", "{x}", std::string(300, 'n')},
                            50,
                            core::FrameMatrix(3, 15)};
  motion.positions_m.setRandom();
  return motion;
}

TEST_CASE("WriteMotion: names are as before, or reported as lost", "[core][export]") {
  const core::MarkerMotion markers = OddlyNamedMarkers();
  for (const auto format :
       {FileFormat::kTrc, FileFormat::kC3d, FileFormat::kCsv, FileFormat::kBvh}) {
    CAPTURE(core::InfoOf(format).name);
    const auto written = core::WriteMotion(format, markers);
    REQUIRE(written.ok());
    const core::Motion read = Back(format, written->bytes);
    std::vector<std::string> back;
    if (const auto* const points = std::get_if<core::MarkerMotion>(&read)) {
      back = points->names;
    } else {
      for (const core::Joint& joint : std::get<core::JointMotion>(read).skeleton->joints()) {
        back.push_back(joint.name);
      }
    }
    std::string lost;
    for (const std::string& loss : written->losses) lost += loss + "\n";
    INFO(lost);
    std::size_t changed = 0;
    for (const std::string& name : markers.names) {
      if (std::find(back.begin(), back.end(), name) == back.end()) ++changed;
    }
    CHECK((changed > 0) == (lost.find("names: ") != lost.npos));
    CHECK_THAT(lost, Catch::Contains("' left arm ' is '"));
  }
  CHECK(core::WriteMotion(FileFormat::kTrc, TwoMarkers())->losses.empty());
  const auto glb = core::WriteMotion(FileFormat::kGltf, markers);
  REQUIRE(glb.ok());
  CHECK_THAT(glb->losses.back(), Catch::Contains("names: 2 of 6 are changed: 'left"));
}

TEST_CASE("WriteMotion: limits and axes of joints are reported as lost", "[core][export]") {
  std::vector<core::Joint> joints = OddJoints();
  const auto losses = [](FileFormat format, const core::JointMotion& motion) {
    const auto written = core::WriteMotion(format, motion);
    REQUIRE(written.ok());
    return written->losses;
  };
  joints[1].dofs[0].lower = -1;
  const core::JointMotion limited = RandomMotion(joints, 3, 50, 1);
  for (const auto format : {FileFormat::kBvh, FileFormat::kGltf, FileFormat::kNpz}) {
    const std::vector<std::string> lost = losses(format, limited);
    REQUIRE(lost.size() >= 2);
    CHECK_THAT(lost[0], Catch::StartsWith("joint limits: "));
    CHECK_THAT(lost[1], Catch::StartsWith("joint axes: "));
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
