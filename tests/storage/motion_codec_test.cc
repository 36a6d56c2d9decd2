#include "storage/blob/motion_codec.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>

namespace motiondb::tests::motion_codec_test {
namespace {

using core::Dof;

core::MotionFile Joints() {
  std::vector<core::Joint> joints = {
      {.name = "hips",
       .dofs = {{Dof::Kind::kTranslation, Eigen::Vector3d::UnitX()}, {.lower = -1, .upper = 2}}},
      {.name = "head", .parent = 0, .offset_m = {0, 0.5, 0}}};
  auto skeleton = core::Skeleton::Create("figure", std::move(joints));
  REQUIRE(skeleton.ok());
  core::JointMotion motion{std::make_shared<core::Skeleton>(*std::move(skeleton)), 60,
                           core::JointMatrix::Random(7, 2)};
  return {std::move(motion),
          {0.01,
           core::Provenance::kStated,
           core::UpAxis::kMinusZ,
           core::Provenance::kDeduced,
           {"a note", ""}},
          "walk"};
}

core::MotionFile Markers() {
  core::MarkerMotion motion{{"a", "b"}, 120, core::FrameMatrix::Random(5, 6), 27};
  motion.positions_m.row(2).head<3>().setConstant(std::numeric_limits<float>::quiet_NaN());
  return {std::move(motion), {}};
}

std::string Encoded(const core::MotionFile& file) {
  storage::StringSink sink;
  REQUIRE(storage::EncodeMotion(file, sink).ok());
  return sink.bytes();
}

absl::StatusOr<core::MotionFile> Decoded(const std::string& bytes) {
  storage::SpanSource source(std::as_bytes(std::span(bytes)));
  return storage::DecodeMotion(source);
}

TEST_CASE("MotionCodec: joints, markers and reports are preserved", "[storage][blob]") {
  const std::string joints = Encoded(Joints());
  const auto read = Decoded(joints);
  REQUIRE(read.ok());
  CHECK(Encoded(*read) == joints);
  const auto& motion = std::get<core::JointMotion>(read->motion);
  CHECK(motion.frame_rate_hz == 60);
  CHECK(motion.angles.rows() == 7);
  CHECK(motion.skeleton->joints()[1].name == "head");
  CHECK(motion.skeleton->joints()[0].dofs[1].upper == 2);
  CHECK(read->report.up_axis == core::UpAxis::kMinusZ);
  CHECK(read->report.up_provenance == core::Provenance::kDeduced);
  CHECK(read->take == "walk");
  CHECK(read->report.notes == std::vector<std::string>{"a note", ""});

  const std::string markers = Encoded(Markers());
  const auto points = Decoded(markers);
  REQUIRE(points.ok());
  CHECK(Encoded(*points) == markers);
  CHECK(std::get<core::MarkerMotion>(points->motion).first_frame == 27);
  CHECK(std::isnan(std::get<core::MarkerMotion>(points->motion).positions_m(2, 1)));
}

TEST_CASE("MotionCodec: every truncation and extension is refused", "[storage][blob]") {
  for (const core::MotionFile& file : {Joints(), Markers()}) {
    const std::string bytes = Encoded(file);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      CHECK(absl::IsDataLoss(Decoded(bytes.substr(0, length)).status()));
    }
    CHECK(absl::IsDataLoss(Decoded(bytes + "x").status()));
  }
}

TEST_CASE("MotionCodec: motion that no reader returns is refused", "[storage][blob]") {
  const auto refused = [](const core::MotionFile& file) {
    return absl::IsDataLoss(Decoded(Encoded(file)).status());
  };
  const auto changed = [&](auto change) {
    core::MotionFile joints = Joints();
    change(joints);
    return refused(joints);
  };
  CHECK(changed([](auto& file) { file.report.metres_per_unit = 0; }));
  CHECK(changed([](auto& file) { file.report.metres_per_unit = std::nan(""); }));
  CHECK(changed([](auto& file) { std::get<0>(file.motion).frame_rate_hz = 0; }));
  CHECK(changed([](auto& file) { std::get<0>(file.motion).angles(3, 1) = std::nan(""); }));
  CHECK(changed([](auto& file) { std::get<0>(file.motion).angles.resize(0, 2); }));
  core::MotionFile markers = Markers();
  std::get<1>(markers.motion).names[1] = "a";
  CHECK(refused(markers));
  markers = Markers();
  std::get<1>(markers.motion).positions_m(0, 0) = std::numeric_limits<float>::quiet_NaN();
  CHECK(refused(markers));
  markers = Markers();
  std::get<1>(markers.motion).positions_m(0, 0) = std::numeric_limits<float>::infinity();
  CHECK(refused(markers));
}

}  // namespace
}  // namespace motiondb::tests::motion_codec_test
