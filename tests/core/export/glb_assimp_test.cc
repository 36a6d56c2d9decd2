// GLB files that we write are read correctly by assimp, a widely used importer.
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/export/odd_skeleton.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests::glb_assimp_test {
namespace {

using core::JointMotion;
using Eigen::Vector3d;

Eigen::Matrix4d ToMatrix(const aiMatrix4x4& m) {
  return Eigen::Matrix<ai_real, 4, 4, Eigen::RowMajor>(&m.a1).cast<double>();
}

// Returns the key of a frame, or the only one. Times are in ticks.
template <typename Key>
const Key& KeyAt(const Key* keys, unsigned count, unsigned frame, double time) {
  REQUIRE(count > 0);
  if (count == 1) return keys[0];
  REQUIRE(frame < count);
  CHECK(keys[frame].mTime == Approx(time).epsilon(1e-6));
  return keys[frame];
}

// A scene as in a player: the transform of each node is that of its channel, if it has one.
class GlbPlayer {
 public:
  explicit GlbPlayer(const aiScene& scene) : scene_(scene) {
    REQUIRE(scene.mNumAnimations == 1);
    const aiAnimation& animation = *scene.mAnimations[0];
    for (unsigned c = 0; c < animation.mNumChannels; ++c) {
      channels_[animation.mChannels[c]->mNodeName.C_Str()] = animation.mChannels[c];
    }
  }

  // Returns the transforms of all nodes at a frame (y up, m); at rest if it is negative.
  std::map<std::string, Eigen::Matrix4d> At(int frame, double rate_hz) const {
    std::map<std::string, Eigen::Matrix4d> poses;
    Visit(*scene_.mRootNode, Eigen::Matrix4d::Identity(), frame,
          frame / rate_hz * scene_.mAnimations[0]->mTicksPerSecond, poses);
    return poses;
  }

 private:
  void Visit(const aiNode& node, const Eigen::Matrix4d& world_from_parent, int frame, double time,
             std::map<std::string, Eigen::Matrix4d>& poses) const {
    Eigen::Matrix4d local = ToMatrix(node.mTransformation);
    const std::string name = node.mName.C_Str();
    if (const auto at = channels_.find(name); frame >= 0 && at != channels_.end()) {
      const aiNodeAnim& channel = *at->second;
      const auto number = static_cast<unsigned>(frame);
      const aiVector3D position =
          KeyAt(channel.mPositionKeys, channel.mNumPositionKeys, number, time).mValue;
      const aiQuaternion turn =
          KeyAt(channel.mRotationKeys, channel.mNumRotationKeys, number, time).mValue;
      local.setIdentity();
      local.topLeftCorner<3, 3>() =
          Eigen::Quaterniond(turn.w, turn.x, turn.y, turn.z).toRotationMatrix();
      local.topRightCorner<3, 1>() = Vector3d(position.x, position.y, position.z);
    }
    const Eigen::Matrix4d world = world_from_parent * local;
    REQUIRE(poses.emplace(name, world).second);
    for (unsigned c = 0; c < node.mNumChildren; ++c) {
      Visit(*node.mChildren[c], world, frame, time, poses);
    }
  }

  const aiScene& scene_;
  std::map<std::string, const aiNodeAnim*> channels_;
};

// The mesh follows the joints of the skin, and does not move at rest.
void CheckMesh(const aiScene& scene, const GlbPlayer& player, const JointMotion& motion) {
  REQUIRE(scene.mNumMeshes == 1);
  const aiMesh& mesh = *scene.mMeshes[0];
  CHECK(mesh.mNumBones == static_cast<unsigned>(motion.skeleton->joint_count()));
  CHECK(mesh.mNumFaces % 8 == 0);
  const auto rest = player.At(-1, motion.frame_rate_hz);
  double weights = 0;
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    CHECK((rest.at(bone.mName.C_Str()) * ToMatrix(bone.mOffsetMatrix)).isIdentity(1e-5));
    for (unsigned w = 0; w < bone.mNumWeights; ++w) weights += bone.mWeights[w].mWeight;
  }
  CHECK(weights == Approx(mesh.mNumVertices));
}

// Reads the motion as GLB with assimp; every joint must be within 1e-5 of the figure's size (at
// least 1 m) in every frame.
void CheckWithAssimp(const JointMotion& motion) {
  const auto bytes = core::WriteGlb(motion);
  INFO(MessageOf(bytes.status()));
  REQUIRE(bytes.ok());
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(bytes->data(), bytes->size(), 0, "glb");
  INFO(importer.GetErrorString());
  REQUIRE(scene != nullptr);
  const GlbPlayer player(*scene);
  CheckMesh(*scene, player, motion);
  double size = 1;
  double max_distance = 0;
  for (int frame = 0; frame < motion.angles.rows(); ++frame) {
    const auto poses = player.At(frame, motion.frame_rate_hz);
    const auto ours = core::ForwardKinematics(*motion.skeleton, motion.angles.row(frame));
    for (std::size_t j = 0; j < ours.size(); ++j) {
      const auto at = poses.find(motion.skeleton->joints()[j].name);
      REQUIRE(at != poses.end());
      const Vector3d found = at->second.topRightCorner<3, 1>();
      const Vector3d world = {found.x(), -found.z(), found.y()};
      max_distance = std::max(max_distance, (world - ours[j].translation()).norm());
      size = std::max(size, (ours[j].translation() - ours[0].translation()).norm());
    }
  }
  CHECK(max_distance < 1e-5 * size);
}

}  // namespace

TEST_CASE("WriteGlb: assimp reads every joint of a stick figure", "[core][format]") {
  const std::string text = WriteBvh(StickFigure{});
  CheckWithAssimp(Joints(ReadText(core::FileFormat::kBvh, text)));
}

TEST_CASE("WriteGlb: assimp reads every joint of an odd skeleton", "[core][format]") {
  CheckWithAssimp(RandomMotion(OddJoints(), 25, 29.97, 3));
}

TEST_CASE("WriteGlb: assimp reads a single frame", "[core][format]") {
  CheckWithAssimp(RandomMotion({{.name = "root", .offset_m = {0, 0, 1}},
                                {.name = "arm", .parent = 0, .offset_m = {0, 1, 0}}},
                               1, 100, 1));
}

TEST_CASE("WriteGlb: assimp reads every joint of recorded motion", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::string amc = ReadFile(DataDir() / "cmu/02/02_01.amc");
  const std::string asf = ReadFile(DataDir() / "cmu/02/02.asf");
  const auto acclaim =
      core::ReadMotionFile(core::FileFormat::kAmc, {"motion.amc", amc}, core::SourceFile{"s", asf});
  CheckWithAssimp(Joints(acclaim));
  const std::string bvh = ReadFile(DataDir() / "formats/same-motion/02_01.motionbuilder.bvh");
  CheckWithAssimp(Joints(ReadText(core::FileFormat::kBvh, bvh)));
}

}  // namespace motiondb::tests::glb_assimp_test
