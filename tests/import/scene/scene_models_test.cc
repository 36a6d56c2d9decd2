// Scenes of the package assimp-testmodels, and motion that assimp exports as glTF.
#include <assimp/cexport.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/motion/forward_kinematics.h"
#include "import/scene/scene_reader.h"
#include "tests/core/format/reading.h"
#include "tests/import/scene/scene_player.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::scene_models_test {
namespace {

using core::FileFormat;
using core::UpAxis;
using Eigen::Vector3d;

std::filesystem::path ModelDir() { return "/usr/share/assimp/models"; }

#define MOTIONDB_REQUIRE_MODELS()                                    \
  if (!std::filesystem::exists(ModelDir())) {                        \
    WARN("skipped: the package assimp-testmodels is not installed"); \
    return;                                                          \
  }                                                                  \
  static_assert(true)

struct Model {
  std::string path;  // below ModelDir()
  FileFormat format;
  std::string take;
};

// Returns the figure's size: the diagonal of the box around its joints in frame 0.
double SizeOf(const core::FrameMatrix& positions) {
  Eigen::AlignedBox3f box;
  for (Eigen::Index j = 0; j < positions.cols(); j += 3) {
    box.extend(positions.block<1, 3>(0, j).transpose());
  }
  return box.diagonal().norm();
}

}  // namespace

TEST_CASE("Scene: packaged animations play as in assimp", "[import][scene]") {
  MOTIONDB_REQUIRE_MODELS();
  const std::vector<Model> models = {
      {"FBX/animation_with_skeleton.fbx", FileFormat::kFbx, ""},
      {"FBX/huesitos.fbx", FileFormat::kFbx, ""},
      {"glTF2/simple_skin/simple_skin.gltf", FileFormat::kGltf, ""},
      {"Collada/box_nested_animation.dae", FileFormat::kCollada, ""},
      {"Collada/anims_with_full_rotations_between_keys.DAE", FileFormat::kCollada, ""}};
  for (const Model& model : models) {
    INFO(model.path);
    const std::filesystem::path path = ModelDir() / model.path;
    const std::string bytes = ReadFile(path);
    core::ReadOptions options;
    options.metres_per_unit = 1;  // positions as in the file
    const auto file = importer::ReadScene(model.format, {.name = "x", .bytes = bytes}, options);
    const core::JointMotion& motion = Joints(file);
    const core::FrameMatrix positions = core::JointPositions(motion);
    const double size = std::max(SizeOf(positions), 1.0);

    Assimp::Importer importer;
    importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
    const aiScene* const scene = importer.ReadFile(path.string(), 0);
    REQUIRE(scene != nullptr);
    REQUIRE(scene->mNumAnimations == 1);
    const ScenePlayer player(*scene, 0);
    for (Eigen::Index frame = 0; frame < positions.rows(); ++frame) {
      const double seconds = static_cast<double>(frame) / motion.frame_rate_hz;
      const auto expected = player.At(player.FirstTick() + seconds * player.TicksPerSecond());
      for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
        const std::string& name = motion.skeleton->joints()[j].name;
        // assimp converts Collada to y up and metres.
        const Vector3d& at = expected.at(name);
        const Vector3d in_world(at.x(), -at.z(), at.y());
        const Vector3d read = positions.block<1, 3>(frame, 3 * j).transpose().cast<double>();
        INFO("frame " << frame << ", joint " << name);
        CHECK((read - in_world).norm() < 1e-4 * size);
      }
    }
  }
}

TEST_CASE("Scene: every packaged file loads or is rejected with a reason", "[import][scene]") {
  MOTIONDB_REQUIRE_MODELS();
  const std::map<std::string, FileFormat> formats = {{".fbx", FileFormat::kFbx},
                                                     {".gltf", FileFormat::kGltf},
                                                     {".glb", FileFormat::kGltf},
                                                     {".dae", FileFormat::kCollada}};
  int loaded = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(ModelDir())) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    const auto format = formats.find(extension);
    if (format == formats.end()) continue;
    const std::string name = entry.path().filename().string();
    INFO(name);
    const auto file =
        importer::ReadScene(format->second, {.name = name, .bytes = ReadFile(entry.path())}, {});
    if (file.ok()) {
      ++loaded;
      CHECK(Joints(file).angles.allFinite());
    } else {
      CHECK(ErrorMessageOf(file).starts_with(name + ": "));
    }
  }
  CHECK(loaded >= 5);
}

TEST_CASE("Scene: a take of a packaged file can be chosen", "[import][scene]") {
  MOTIONDB_REQUIRE_MODELS();
  // Its numbers follow white space, which assimp 5.2 does not read.
  const std::string bytes = ReadFile(ModelDir() / "Collada/library_animation_clips.dae");
  core::ReadOptions options;
  options.take = "combinedAnim_1";
  const auto file =
      importer::ReadScene(FileFormat::kCollada, {.name = "x", .bytes = bytes}, options);
  CHECK(Joints(file).skeleton->joint_count() == 5);
  CHECK(Joints(file).frame_rate_hz == 24);
}

TEST_CASE("Scene: a person exported to glTF moves as in the BVH file", "[import][scene]") {
  MOTIONDB_REQUIRE_MODELS();
  const std::filesystem::path path = ModelDir() / "BVH/Boxing_Toes.bvh";
  core::ReadOptions options;
  options.metres_per_unit = 1;
  options.up_axis = UpAxis::kY;
  const std::string text = ReadFile(path);
  const auto bvh =
      core::ReadMotionFile(FileFormat::kBvh, {.name = "x", .bytes = text}, {}, options);
  const core::JointMotion& original = Joints(bvh);
  const core::FrameMatrix expected = core::JointPositions(original);
  const double size = SizeOf(expected);

  Assimp::Importer importer;
  const aiScene* const scene = importer.ReadFile(path.string(), 0);
  REQUIRE(scene != nullptr);
  // What assimp 5.2 writes as FBX and Collada cannot be read, by assimp either.
  Assimp::Exporter exporter;
  const aiExportDataBlob* const blob = exporter.ExportToBlob(scene, "glb2");
  REQUIRE(blob != nullptr);
  const auto file = importer::ReadScene(
      FileFormat::kGltf, {.name = "x", .bytes = {static_cast<const char*>(blob->data), blob->size}},
      options);
  const core::JointMotion& motion = Joints(file);
  const core::FrameMatrix positions = core::JointPositions(motion);
  REQUIRE(std::abs(positions.rows() - expected.rows()) <= 1);
  CHECK(motion.frame_rate_hz == Approx(original.frame_rate_hz).epsilon(1e-3));
  int compared = 0;
  for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
    const int k = original.skeleton->FindJoint(motion.skeleton->joints()[j].name);
    if (k < 0) continue;
    ++compared;
    const Eigen::Index rows = std::min(positions.rows(), expected.rows());
    const double error = (positions.block(0, 3 * j, rows, 3) - expected.block(0, 3 * k, rows, 3))
                             .rowwise()
                             .norm()
                             .maxCoeff();
    INFO(motion.skeleton->joints()[j].name);
    CHECK(error < 1e-4 * size);
  }
  CHECK(compared >= 20);
}

}  // namespace motiondb::tests::scene_models_test
