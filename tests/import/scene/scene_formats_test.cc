// Conventions of FBX and Collada scenes.
#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <string_view>

#include "core/motion/forward_kinematics.h"
#include "import/scene/scene_file.h"
#include "tests/import/imported.h"
#include "tests/import/scene/scene_files.h"

namespace motiondb::tests::scene_formats_test {
namespace {

using Catch::Contains;
using core::FileFormat;
using core::Provenance;
using core::UpAxis;
using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;

absl::StatusOr<core::MotionFile> ReadFbx(const FbxFile& file) {
  return ReadSceneBytes(FileFormat::kFbx, file.Text());
}

absl::StatusOr<core::MotionFile> ReadCollada(const ColladaFile& file,
                                             const core::ReadOptions& options = {}) {
  return ReadSceneBytes(FileFormat::kCollada, file.Text(), options);
}

Eigen::Matrix3d EulerXyz(const std::array<double, 3>& degrees) {
  return (Eigen::AngleAxisd(degrees[2] * kRadians, Vector3d::UnitZ()) *
          Eigen::AngleAxisd(degrees[1] * kRadians, Vector3d::UnitY()) *
          Eigen::AngleAxisd(degrees[0] * kRadians, Vector3d::UnitX()))
      .toRotationMatrix();
}

std::array<double, 3> PropertyOf(const FbxModel& model, const std::string& name) {
  const auto found = model.properties.find(name);
  return found == model.properties.end() ? std::array<double, 3>{} : found->second;
}

// FBX: translation * offset * pivot * pre-rotation * rotation * inverse post-rotation * inverse
// pivot.
Eigen::Isometry3d FbxLocal(const FbxModel& model, const std::array<double, 3>& rotation) {
  const auto shift = [&](const std::string& name, double sign) {
    const std::array<double, 3> v = PropertyOf(model, name);
    return Eigen::Translation3d(sign * Vector3d(v[0], v[1], v[2]));
  };
  return shift("Lcl Translation", 1) * shift("RotationOffset", 1) * shift("RotationPivot", 1) *
         Eigen::Isometry3d(EulerXyz(PropertyOf(model, "PreRotation")) * EulerXyz(rotation) *
                           EulerXyz(PropertyOf(model, "PostRotation")).transpose()) *
         shift("RotationPivot", -1);
}

}  // namespace

TEST_CASE("Scene: layers of an FBX take are reported", "[import][scene]") {
  FbxFile file;
  file.models = {{"Hips", -1, {{"Lcl Translation", {0, 100, 0}}}},
                 {"Head", 0, {{"Lcl Translation", {0, 50, 0}}}}};
  file.curves = {{0, "Lcl Rotation", {{{{0, 0}, {0.1, 30}}, {}, {}}}}};
  const auto notes_of = [](const std::string& text) {
    return NotesOf(ReadSceneBytes(FileFormat::kFbx, text));
  };
  const std::string one = file.Text();
  CHECK_THAT(notes_of(one), !Contains("layer"));
  const std::string two =
      Replaced(one, "AnimationLayer: 2,",
               "AnimationLayer: 3, \"AnimLayer::Extra\", \"\" {\n}\nAnimationLayer: 2,");
  CHECK_THAT(notes_of(two), Contains("2 animation layers in 1 take: layers are not blended"));
  using namespace std::string_literals;
  const std::string binary = "Kaydara FBX Binary  \0S\x0e\0\0\0AnimationLayer\x0e"s +
                             "AnimationStack\x0e" + "AnimationLayer";
  CHECK_FALSE(importer::NoteOnFbxLayers(binary).has_value());
  CHECK(importer::NoteOnFbxLayers(binary + "\x0e" + "AnimationLayer").has_value());
}

TEST_CASE("Scene: FBX pre-rotations, post-rotations and pivots", "[import][scene]") {
  const std::array<double, 3> up = {1, 10, 2};
  const std::array<double, 3> pre = {10, 20, 90};
  const std::array<double, 3> post = {30, -20, 10};
  FbxFile file;
  file.models = {
      {"Root", -1, {{"Lcl Translation", {0, 50, 0}}}},
      {"Pre", 0, {{"Lcl Translation", up}, {"PreRotation", pre}}},
      {"Post", 1, {{"Lcl Translation", up}, {"PreRotation", pre}, {"PostRotation", post}}},
      {"Only post", 2, {{"Lcl Translation", up}, {"PostRotation", post}}},
      {"Pivot",
       3,
       {{"Lcl Translation", up},
        {"PreRotation", pre},
        {"PostRotation", post},
        {"RotationPivot", {1, 2, 3}},
        {"RotationOffset", {3, 1, 0}},
        {"GeometricTranslation", {5, 5, 5}}}},
      {"Still", 4, {{"Lcl Translation", up}, {"PreRotation", pre}, {"PostRotation", post}}},
      {"Tip", 5, {{"Lcl Translation", up}}}};
  constexpr int kFrames = 4;
  for (int m = 0; m < 5; ++m) {
    FbxCurves turn{.model = m, .property = "Lcl Rotation", .keys = {}};
    for (int frame = 0; frame < kFrames; ++frame) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        turn.keys[axis].emplace_back(frame / 30.0,
                                     (20.0 - 5.0 * static_cast<double>(axis)) * frame);
      }
    }
    file.curves.push_back(turn);
  }
  const auto read = ReadFbx(file);
  const core::JointMotion& motion = Joints(read);
  CHECK(motion.frame_rate_hz == 30);
  CHECK(read->report.metres_per_unit == 0.01);
  CHECK(read->report.unit_provenance == Provenance::kStated);
  REQUIRE(motion.angles.rows() == kFrames);
  for (int frame = 0; frame < kFrames; ++frame) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (std::size_t m = 0; m < file.models.size(); ++m) {
      const bool is_still = m >= 5;
      pose = pose * FbxLocal(file.models[m],
                             is_still
                                 ? std::array<double, 3>{}
                                 : std::array<double, 3>{20.0 * frame, 15.0 * frame, 10.0 * frame});
      const Vector3d at = 0.01 * pose.translation();
      INFO("frame " << frame << ", model " << file.models[m].name);
      CHECK(Near(PositionOf(motion, file.models[m].name, frame), {at.x(), -at.z(), at.y()}));
    }
  }
}

TEST_CASE("Scene: FBX units and axes", "[import][scene]") {
  FbxFile file;
  file.models = {{"Hips", -1, {{"Lcl Translation", {0, 0, 40}}}},
                 {"Head", 0, {{"Lcl Translation", {0, 0, 20}}}}};
  file.curves = {{0, "Lcl Rotation", {{{{0, 0}, {0.1, 30}}, {}, {}}}}};
  file.unit_cm = 2.54;
  file.up_axis = 2;
  const auto read = ReadFbx(file);
  CHECK(read->report.metres_per_unit == Approx(0.0254));
  CHECK(read->report.up_axis == UpAxis::kZ);
  CHECK(read->report.up_provenance == Provenance::kStated);
  CHECK(Near(PositionOf(Joints(read), "Head", 0), {0, 0, 60 * 0.0254}));
  // The keys are sparse: the rate of the file counts.
  CHECK(Joints(read).frame_rate_hz == 30);
  CHECK(Joints(read).angles.rows() == 4);
}

TEST_CASE("Scene: an FBX take is the range that the file states", "[import][scene]") {
  FbxFile file;
  file.models = {{"Hips", -1, {}}, {"Head", 0, {{"Lcl Translation", {0, 100, 0}}}}};
  file.curves = {{0, "Lcl Rotation", {}}};
  for (int key = 0; key <= 30; ++key) file.curves[0].keys[0].emplace_back(key / 30.0, 3.0 * key);
  file.range_s = {0.5, 0.9};
  const auto read = ReadFbx(file);
  // assimp keeps the first key, at -0.5 s from the begin of the range.
  REQUIRE(Joints(read).angles.rows() == 13);
  for (const int frame : {0, 12}) {
    const double turn = 3.0 * (15 + frame) * kRadians;
    CHECK(Near(PositionOf(Joints(read), "Head", frame), {0, -std::sin(turn), std::cos(turn)}));
  }
}

TEST_CASE("Scene: a stated unit that makes no person is kept, with a note", "[import][scene]") {
  FbxFile file;
  file.models = {{"Hips", -1, {{"Lcl Translation", {0, 90, 0}}}},
                 {"Head", 0, {{"Lcl Translation", {0, 65, 0}}}},
                 {"LeftFoot", 0, {{"Lcl Translation", {10, -85, 0}}}}};
  file.curves = {{0, "Lcl Rotation", {{{{0, 0}, {0.1, 30}}, {}, {}}}}};
  CHECK(ReadFbx(file)->report.notes.empty());
  file.unit_cm = 100;
  const auto giant = ReadFbx(file);
  CHECK(giant->report.metres_per_unit == 1);
  CHECK(giant->report.unit_provenance == Provenance::kStated);
  REQUIRE(giant->report.notes.size() == 1);
  CHECK_THAT(giant->report.notes[0], Contains("the stated unit gives a stature of 151 m"));
}

TEST_CASE("Scene: Collada units and axes", "[import][scene]") {
  ColladaFile file;
  const auto z_up = ReadCollada(file);
  CHECK(z_up->report.metres_per_unit == Approx(0.01));
  CHECK(z_up->report.unit_provenance == Provenance::kStated);
  CHECK(z_up->report.up_axis == UpAxis::kZ);
  CHECK(Near(PositionOf(Joints(z_up), "Head", 0), {0, 0, 1.5}));
  CHECK(Near(PositionOf(Joints(z_up), "Head", 2),
             {0, -0.5 * std::sin(20 * kRadians), 1 + 0.5 * std::cos(20 * kRadians)}));
  CHECK(Joints(z_up).frame_rate_hz == 25);

  core::ReadOptions inches;
  inches.metres_per_unit = 0.0254;
  CHECK(Near(PositionOf(Joints(ReadCollada(file, inches)), "Hips", 0), {0, 0, 2.54}));
  file.asset = R"(<unit meter="0.5"/><!-- <up_axis>Z_UP</up_axis> --><up_axis>Y_UP</up_axis>)";
  CHECK(Near(PositionOf(Joints(ReadCollada(file)), "Head", 0), {0, -75, 0}));
  file.asset = "";
  const auto unstated = ReadCollada(file);
  CHECK(unstated->report.unit_provenance == Provenance::kAssumed);
  CHECK(unstated->report.up_provenance == Provenance::kAssumed);
  CHECK(Near(PositionOf(Joints(unstated), "Head", 0), {0, -150, 0}));
  file.asset = R"(<unit meter="0"/>)";
  CHECK(ErrorMessageOf(ReadCollada(file)) == "walk.dae: expected a unit above 0 m, found 0 m");
  file.asset = R"(<unit meter="-1"/><up_axis>Z_UP</up_axis>)";
  CHECK(Near(PositionOf(Joints(ReadCollada(file)), "Head", 0), {0, 0, 150}));
}

TEST_CASE("Scene: Collada numbers after white space", "[import][scene]") {
  ColladaFile file;
  file.nodes = Replaced(file.nodes, "<translate>0 0 100", "<translate>\n  0 0 100");
  CHECK(Near(PositionOf(Joints(ReadCollada(file)), "Head", 0), {0, 0, 1.5}));
}

}  // namespace motiondb::tests::scene_formats_test
