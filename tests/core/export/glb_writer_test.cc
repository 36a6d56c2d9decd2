#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "core/export/writers.h"
#include "core/motion/forward_kinematics.h"
#include "tests/core/export/glb_file.h"
#include "tests/core/export/odd_skeleton.h"
#include "tests/core/format/reading.h"
#include "tests/support/real_data.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests::glb_writer_test {
namespace {

using Catch::Contains;
using core::JointMotion;
using Eigen::Vector3d;

std::string Written(const JointMotion& motion) {
  auto bytes = core::WriteGlb(motion);
  INFO(MessageOf(bytes.status()));
  REQUIRE(bytes.ok());
  return *std::move(bytes);
}

JointMotion Stick() {
  const std::string text = WriteBvh(StickFigure{});
  return Joints(ReadText(core::FileFormat::kBvh, text));
}

JointMotion Odd() { return RandomMotion(OddJoints(), 20, 29.97, 3); }

// Returns the maximum distance (m) of a node from its joint in all frames.
double MaxDistance(const JointMotion& motion, const GlbFile& glb) {
  double max_distance = 0;
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    const auto nodes = glb.WorldPoses(frame);
    const auto joints = core::ForwardKinematics(*motion.skeleton, motion.angles.row(frame));
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Vector3d p = joints[j].translation();
      max_distance = std::max(max_distance,
                              (nodes.at(j).translation() - Vector3d(p.x(), p.z(), -p.y())).norm());
    }
  }
  return max_distance;
}

void CheckAnimation(const JointMotion& motion, const GlbFile& glb) {
  REQUIRE(glb.json["animations"].size() == 1);
  const auto& animation = glb.json["animations"][0];
  std::set<std::pair<int, std::string>> targets;
  for (const auto& channel : animation["channels"]) {
    const auto& target = channel["target"];
    CHECK(targets.emplace(target["node"].get<int>(), target["path"].get<std::string>()).second);
    const auto& sampler = animation["samplers"].at(channel["sampler"].get<int>());
    CHECK(sampler.value("interpolation", "LINEAR") == "LINEAR");
    CHECK(sampler["input"] == animation["samplers"][0]["input"]);
    const Eigen::MatrixXd times = glb.Read(sampler["input"]);
    REQUIRE(times.cols() == motion.angles.rows());
    for (Eigen::Index i = 0; i < times.cols(); ++i) {
      CHECK(times(i) == static_cast<float>(static_cast<double>(i) / motion.frame_rate_hz));
    }
    const Eigen::MatrixXd keys = glb.Read(sampler["output"]);
    REQUIRE(keys.cols() == times.cols());
    if (target["path"] != "rotation") continue;
    CHECK(keys(3, 0) >= 0);
    CHECK((keys.colwise().norm().array() - 1).abs().maxCoeff() < 1e-6);
    for (Eigen::Index i = 1; i < keys.cols(); ++i) CHECK(keys.col(i).dot(keys.col(i - 1)) >= 0);
  }
}

// The mesh is skinned to valid joints, and does not move at rest.
void CheckSkin(const GlbFile& glb) {
  const auto& skin = glb.json["skins"].at(0);
  const Eigen::MatrixXd inverse = glb.Read(skin["inverseBindMatrices"]);
  const auto rest = glb.WorldPoses(-1);
  REQUIRE(inverse.cols() == std::ssize(skin["joints"]));
  for (Eigen::Index j = 0; j < inverse.cols(); ++j) {
    const Eigen::Matrix4d bind(inverse.col(j).data());
    CHECK(bind.row(3) == Eigen::RowVector4d(0, 0, 0, 1));
    const auto node = skin["joints"][static_cast<std::size_t>(j)].get<std::size_t>();
    CHECK((rest.at(node).matrix() * bind).isIdentity(1e-5));
  }
  const auto& primitive = glb.json["meshes"].at(0)["primitives"].at(0);
  const Eigen::MatrixXd positions = glb.Read(primitive["attributes"]["POSITION"]);
  const Eigen::MatrixXd joints = glb.Read(primitive["attributes"]["JOINTS_0"]);
  const Eigen::MatrixXd weights = glb.Read(primitive["attributes"]["WEIGHTS_0"]);
  const Eigen::MatrixXd indices = glb.Read(primitive["indices"]);
  REQUIRE(joints.cols() == positions.cols());
  REQUIRE(weights.cols() == positions.cols());
  CHECK(joints.maxCoeff() < static_cast<double>(inverse.cols()));
  CHECK((weights.colwise().sum().array() == 1).all());
  REQUIRE(indices.cols() % 3 == 0);
  CHECK(indices.maxCoeff() == static_cast<double>(positions.cols() - 1));
  // Triangles face away from the middle of their bone.
  for (Eigen::Index t = 0; t < indices.cols(); t += 3) {
    const auto corner = [&](Eigen::Index i) -> Vector3d {
      return positions.col(static_cast<Eigen::Index>(indices(t + i)));
    };
    const Eigen::Index bone = static_cast<Eigen::Index>(indices(t)) / 6 * 6;
    const Vector3d middle = positions.middleCols(bone, 6).rowwise().mean();
    const Vector3d out = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    CHECK(out.dot(corner(0) - middle) > 0);
  }
}

void CheckEverything(const JointMotion& motion) {
  const std::string bytes = Written(motion);
  const GlbFile glb(bytes);
  glb.CheckAccessors();
  CheckAnimation(motion, glb);
  CheckSkin(glb);
  CHECK(MaxDistance(motion, glb) < 1e-5);
}

std::string RefusalOf(const JointMotion& motion) { return ErrorMessageOf(core::WriteGlb(motion)); }

}  // namespace

TEST_CASE("WriteGlb: structure, animation and skin of a stick figure", "[core][format]") {
  CheckEverything(Stick());
}

TEST_CASE("WriteGlb: structure, animation and skin of an odd skeleton", "[core][format]") {
  CheckEverything(Odd());
}

TEST_CASE("WriteGlb: structure, animation and skin of recorded motion", "[core][format][data]") {
  MOTIONDB_REQUIRE_DATA();
  const std::string bvh = ReadFile(DataDir() / "formats/pairs/09_02.daz.bvh");
  CheckEverything(Joints(ReadText(core::FileFormat::kBvh, bvh)));
}

TEST_CASE("WriteGlb: a frame costs only what moves", "[core][format]") {
  JointMotion motion = Stick();
  const std::size_t before = Written(motion).size();
  const Eigen::Index frames = motion.angles.rows();
  motion.angles = motion.angles.replicate(3, 1).eval();
  const std::size_t after = Written(motion).size();
  // A time, the root's position, the rotations of ten joints; and a few digits in the JSON.
  const auto keys = static_cast<std::size_t>(2 * frames) * (4 + 12 + 10 * 16);
  CHECK(after - before >= keys);
  CHECK(after - before < keys + 300);
}

TEST_CASE("WriteGlb: what does not depend on the frames is small", "[core][format]") {
  std::vector<core::Joint> joints;
  joints.reserve(60);
  for (int j = 0; j < 60; ++j) {
    joints.push_back({.name = "a joint of the figure " + std::to_string(j),
                      .parent = j == 0 ? -1 : (j - 1) / 2,
                      .offset_m = {0.01, 0.1, 0.02},
                      .dofs = {{.axis = Vector3d::UnitX()}}});
  }
  CHECK(Written(RandomMotion(joints, 1, 100, 1)).size() < 60'000);
}

TEST_CASE("WriteGlb: names are valid and unique", "[core][format]") {
  const std::string bytes = Written(RandomMotion({{.name = "figure"},
                                                  {.name = "\xFF\"\\\n", .parent = 0},
                                                  {.name = "\xC3\xBF\"\\?", .parent = 0},
                                                  {.name = std::string(300, 'x'), .parent = 0}},
                                                 2, 100, 1));
  const GlbFile glb(bytes);
  std::set<std::string> names;
  for (const auto& node : glb.json["nodes"]) CHECK(names.insert(node["name"]).second);
  CHECK(glb.json["nodes"][0]["name"] == "figure");
  CHECK(glb.json["nodes"][1]["name"] == "\xC3\xBF\"\\?");
  CHECK(glb.json["nodes"][2]["name"] == "\xC3\xBF\"\\?_2");
  CHECK(glb.json["nodes"][3]["name"] == std::string(255, 'x'));
}

TEST_CASE("WriteGlb: several roots share a parent, a single one has none", "[core][format]") {
  const std::string several = Written(Odd());
  CHECK(GlbFile(several).json["nodes"].back()["children"] == nlohmann::json({0, 5, 7}));
  const std::string single = Written(Stick());
  CHECK(GlbFile(single).json["scenes"][0]["nodes"] == nlohmann::json({0, 14}));
}

TEST_CASE("WriteGlb: a single frame without degrees of freedom", "[core][format]") {
  CheckEverything(RandomMotion({{.name = "only", .offset_m = {1, 2, 3}}}, 1, 100, 1));
}

TEST_CASE("WriteGlb: motion that the file cannot express is refused", "[core][format]") {
  JointMotion motion = Stick();
  motion.angles(3, 5) = NAN;
  CHECK(RefusalOf(motion) == "GLB: frame 3 has a joint angle that is not finite");
  motion = Stick();
  motion.angles(7, 0) = 1e300;
  CHECK_THAT(RefusalOf(motion), Contains("joint 'Hips' is 1e+300 m from its parent in frame 7"));
  motion = RandomMotion({{.name = "far", .offset_m = {0, 0, 1e19}}}, 1, 100, 1);
  CHECK_THAT(RefusalOf(motion), Contains("joint 'far' is 1e+19 m from its parent at rest"));
  motion = RandomMotion({{.name = "long"}}, 13'000'000, 100'000, 1);
  CHECK_THAT(RefusalOf(motion), Contains("have the same time in single precision"));
  motion = RandomMotion({{.name = "long"}}, 40'000, 100'000, 1);
  CHECK(core::WriteGlb(motion).ok());
  motion.skeleton = nullptr;
  CHECK(RefusalOf(motion) == "GLB: the motion has no skeleton");
  std::vector<core::Joint> joints(2001);
  for (std::size_t j = 0; j < joints.size(); ++j) joints[j].name = std::to_string(j);
  CHECK(RefusalOf(RandomMotion(joints, 1, 100, 1)) ==
        "GLB: expected at most 2000 joints, found 2001");
  joints.pop_back();
  CHECK(core::WriteGlb(RandomMotion(joints, 1, 100, 1)).ok());
}

}  // namespace motiondb::tests::glb_writer_test
