// BVH files that we write are read correctly by assimp, a widely used importer.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::bvh_assimp_test {
namespace {

using core::Dof;
using core::Joint;
using core::JointMotion;
using Eigen::Vector3d;

Eigen::Matrix4d ToEigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d made;
  made << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3,
      m.d4;
  return made;
}

// A scene as in a player: the transform of each node is that of its channel, if it has one.
class Player {
 public:
  explicit Player(const aiScene& scene) : scene_(scene) {
    REQUIRE(scene.mNumAnimations == 1);
    const aiAnimation& animation = *scene.mAnimations[0];
    for (unsigned c = 0; c < animation.mNumChannels; ++c) {
      channels_[animation.mChannels[c]->mNodeName.C_Str()] = animation.mChannels[c];
    }
  }

  // Returns the positions of all nodes at a frame, in the file's units and axes.
  std::map<std::string, Vector3d> At(unsigned frame) const {
    std::map<std::string, Vector3d> positions;
    Visit(*scene_.mRootNode, Eigen::Matrix4d::Identity(), frame, positions);
    return positions;
  }

  double FrameRate() const { return scene_.mAnimations[0]->mTicksPerSecond; }
  unsigned FrameCount() const { return scene_.mAnimations[0]->mChannels[0]->mNumRotationKeys; }

 private:
  void Visit(const aiNode& node, const Eigen::Matrix4d& world_from_parent, unsigned frame,
             std::map<std::string, Vector3d>& positions) const {
    Eigen::Matrix4d local = ToEigen(node.mTransformation);
    const std::string name = node.mName.C_Str();
    if (const auto at = channels_.find(name); at != channels_.end()) {
      const aiNodeAnim& channel = *at->second;
      REQUIRE(channel.mNumPositionKeys > 0);
      REQUIRE(channel.mNumRotationKeys > frame);
      const aiVector3D& position =
          channel.mPositionKeys[std::min(frame, channel.mNumPositionKeys - 1)].mValue;
      const aiQuaternion& turn = channel.mRotationKeys[frame].mValue;
      local.setIdentity();
      local.topLeftCorner<3, 3>() =
          Eigen::Quaterniond(turn.w, turn.x, turn.y, turn.z).toRotationMatrix();
      local.topRightCorner<3, 1>() = Vector3d(position.x, position.y, position.z);
    }
    const Eigen::Matrix4d world = world_from_parent * local;
    positions[name] = world.topRightCorner<3, 1>();
    for (unsigned c = 0; c < node.mNumChildren; ++c) {
      Visit(*node.mChildren[c], world, frame, positions);
    }
  }

  const aiScene& scene_;
  std::map<std::string, const aiNodeAnim*> channels_;
};

// Returns the maximum distance of a joint from assimp's position, m.
double MaxJointDistance(const JointMotion& motion) {
  const auto text = core::WriteBvh(motion);
  INFO(MessageOf(text.status()));
  REQUIRE(text.ok());
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(text->data(), text->size(), 0, "bvh");
  INFO(importer.GetErrorString());
  REQUIRE(scene != nullptr);
  const Player player(*scene);
  CHECK(player.FrameRate() == Approx(motion.frame_rate_hz));
  CHECK(player.FrameCount() == static_cast<unsigned>(motion.angles.rows()));

  double max_distance = 0;
  const Eigen::Index step = std::max<Eigen::Index>(1, motion.angles.rows() / 20);
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); frame += step) {
    const auto positions = player.At(static_cast<unsigned>(frame));
    const auto ours = core::ForwardKinematics(*motion.skeleton, motion.angles.row(frame));
    for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
      // assimp names end sites after their joints.
      std::string name = motion.skeleton->joints()[j].name;
      if (name.ends_with("_end")) name = "EndSite_" + name.substr(0, name.size() - 4);
      const auto at = positions.find(name);
      CAPTURE(name);
      REQUIRE(at != positions.end());
      const Vector3d& cm = at->second;  // y up
      const Vector3d metres = Vector3d(cm.x(), -cm.z(), cm.y()) / 100;
      max_distance = std::max(max_distance, (metres - ours[j].translation()).norm());
    }
  }
  return max_distance;
}

JointMotion Wave(std::vector<Joint> joints, int frames, double reach) {
  auto skeleton = core::Skeleton::Create("figure", std::move(joints));
  REQUIRE(skeleton.ok());
  JointMotion motion = {std::make_shared<core::Skeleton>(*std::move(skeleton)), 120, {}};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> value(-reach, reach);
  motion.angles = core::JointMatrix::NullaryExpr(frames, motion.skeleton->dof_count(),
                                                 [&] { return value(random); });
  return motion;
}

}  // namespace

TEST_CASE("WriteBvh: assimp reads every joint position of a figure", "[core][format]") {
  const Dof x = {.axis = Vector3d::UnitX()};
  const Dof y = {.axis = Vector3d::UnitY()};
  const Dof z = {.axis = Vector3d::UnitZ()};
  const Dof along_z = {.kind = Dof::Kind::kTranslation, .axis = Vector3d::UnitZ()};
  const Dof along_x = {.kind = Dof::Kind::kTranslation, .axis = Vector3d::UnitX()};
  const double reach = GENERATE(0.4, 3.0);
  const JointMotion motion =
      Wave({{.name = "root", .offset_m = {0, 0, 0.9}, .dofs = {along_x, along_z, z, y, x}},
            {.name = "arm", .parent = 0, .offset_m = {0.1, 0.2, 0.4}, .dofs = {x, y, z}},
            {.name = "hand", .parent = 1, .offset_m = {0, 0.3, 0}, .dofs = {z, x}},
            {.name = "hand_end", .parent = 2, .offset_m = {0, 0.1, 0.05}, .dofs = {}},
            {.name = "leg", .parent = 0, .offset_m = {0, 0.1, -0.1}, .dofs = {y, x}},
            {.name = "foot", .parent = 4, .offset_m = {0, 0, -0.8}, .dofs = {y}},
            {.name = "foot_end", .parent = 5, .offset_m = {0.2, 0, 0}, .dofs = {}}},
           25, reach);
  CHECK(MaxJointDistance(motion) < 1e-3);
  // Both orders of rotation are used.
  const auto text = core::WriteBvh(motion);
  REQUIRE(text.ok());
  CHECK_THAT(*text, Catch::Contains("Zrotation Xrotation Yrotation") &&
                        Catch::Contains("Zrotation Yrotation Xrotation"));
}

TEST_CASE("WriteBvh: assimp reads all joint positions of real motion", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  struct Source {
    const char* motion;
    const char* skeleton;
  };
  for (const Source& source :
       {Source{"cmu/02/02_01.amc", "cmu/02/02.asf"}, Source{"cmu/49/49_02.amc", "cmu/49/49.asf"}}) {
    CAPTURE(source.motion);
    const std::string amc = ReadFile(DataDir() / source.motion);
    const std::string asf = ReadFile(DataDir() / source.skeleton);
    const auto file = core::ReadMotionFile(core::FileFormat::kAmc, {"motion.amc", amc},
                                           core::SourceFile{"skeleton.asf", asf});
    CHECK(MaxJointDistance(Joints(file)) < 1e-3);
  }
}

}  // namespace motiondb::tests::bvh_assimp_test
