// The leg length that Represent divides by: of joints from their bones, of markers by estimate.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/format/marker_set_file.h"
#include "core/motion/states.h"
#include "tests/support/fixed_numbers.h"

namespace motiondb::tests::leg_length_test {
namespace {

constexpr int kPoses = 40;
constexpr int kFrames = 30;
constexpr double kThigh_m = 0.42;
constexpr double kShin_m = 0.4;
constexpr double kLeg_m = kThigh_m + kShin_m;

// Returns a set of two legs with a mapping that makes the knee markers by these rules.
core::MarkerScheme Scheme(const std::string& left_knee, const std::string& right_knee) {
  auto scheme = core::ReadMarkerSetFile(
      {"legs",
       "motiondb-marker-set 1\nname legs\nmarker LHip\nmarker RHip\nmarker LKnee\n"
       "marker RKnee\nmarker LAnkle\nmarker RAnkle\nhips LHip RHip\n"
       "leg LHip LKnee LAnkle\nleg RHip RKnee RAnkle\nmapping rig\n"
       "LHip = lhip\nLAnkle = lfoot\nRHip = rhip\nRAnkle = rfoot\nLKnee = " +
           left_knee + "\nRKnee = " + right_knee + "\n"});
  INFO(scheme.status());
  REQUIRE(scheme.ok());
  return *std::move(scheme);
}

core::MarkerScheme AtJoints() { return Scheme("lknee", "rknee"); }

// The knee markers are below the knees, so a leg that is bent seems to be shorter.
core::MarkerScheme Mixed() { return Scheme("0.7 lknee + 0.3 lfoot", "0.7 rknee + 0.3 rfoot"); }

// How far a joint is from its parent: fixed, or a translation of the joint.
enum class Bones { kFixed, kTranslations };

struct Bone {
  std::string name;
  int parent;
  Eigen::Vector3d offset_m;
};

std::vector<Bone> Skeletal() {
  return {{"root", -1, {0, 0, 0.95}},      {"lhip", 0, {0, 0.09, -0.04}},
          {"lknee", 1, {0, 0, -kThigh_m}}, {"lfoot", 2, {0, 0, -kShin_m}},
          {"rhip", 0, {0, -0.09, -0.04}},  {"rknee", 4, {0, 0, -kThigh_m}},
          {"rfoot", 5, {0, 0, -kShin_m}}};
}

// A root with six channels, and joints with three rotations or six channels.
std::shared_ptr<const core::Skeleton> Legs(Bones bones) {
  std::vector<core::Joint> joints;
  for (const Bone& bone : Skeletal()) {
    const bool translates = bone.parent < 0 || bones == Bones::kTranslations;
    core::Joint joint{.name = bone.name, .parent = bone.parent};
    if (!translates) joint.offset_m = bone.offset_m;
    for (const auto kind : {core::Dof::Kind::kTranslation, core::Dof::Kind::kRotation}) {
      if (kind == core::Dof::Kind::kTranslation && !translates) continue;
      for (int axis = 0; axis < 3; ++axis)
        joint.dofs.push_back({kind, Eigen::Vector3d::Unit(axis)});
    }
    joints.push_back(std::move(joint));
  }
  auto skeleton = core::Skeleton::Create("legs", std::move(joints));
  REQUIRE(skeleton.ok());
  return std::make_shared<core::Skeleton>(*std::move(skeleton));
}

// Returns motions that hold a random pose each: root anywhere, turned by up to 0.5 rad, joints bent
// by up to 1.2 rad about each axis.
std::vector<core::JointMotion> RandomPoses(Bones bones) {
  const auto skeleton = Legs(bones);
  const std::vector<Bone> skeletal = Skeletal();
  const core::FrameMatrix random = FixedNumbers(kPoses, skeleton->dof_count());
  std::vector<core::JointMotion> motions;
  for (int pose = 0; pose < kPoses; ++pose) {
    core::JointMotion motion{skeleton, 60, core::JointMatrix(kFrames, skeleton->dof_count())};
    for (int j = 0; j < skeleton->joint_count(); ++j) {
      const core::Joint& joint = skeleton->joints()[j];
      for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
        const int dof = skeleton->first_dof(j) + static_cast<int>(k);
        const bool is_rotation = joint.dofs[k].kind == core::Dof::Kind::kRotation;
        double value = random(pose, dof);
        if (is_rotation) {
          value *= joint.parent < 0 ? 0.5 : 1.2;
        } else if (joint.parent >= 0) {
          value = skeletal[j].offset_m[static_cast<Eigen::Index>(k)];
        }
        motion.angles.col(dof).setConstant(value);
      }
    }
    motions.push_back(std::move(motion));
  }
  return motions;
}

double RepresentedLeg(const core::MarkerScheme& scheme, const core::Motion& motion) {
  const auto states = core::Represent(scheme, motion, 60, core::kObservation);
  INFO(states.status());
  REQUIRE(states.ok());
  return states->leg_length_m;
}

core::MarkerMotion MarkersOf(const core::MarkerScheme& scheme, const core::JointMotion& motion) {
  auto markers = core::ApplyScheme(scheme, motion);
  INFO(markers.status());
  REQUIRE(markers.ok());
  return *std::move(markers);
}

}  // namespace

TEST_CASE("Represent: the leg length of joints does not depend on the pose", "[core][motion]") {
  const Bones bones = GENERATE(Bones::kFixed, Bones::kTranslations);
  double least_estimate = kLeg_m;
  for (const core::JointMotion& motion : RandomPoses(bones)) {
    CHECK(RepresentedLeg(Mixed(), motion) == Approx(kLeg_m).epsilon(0.01));
    CHECK(RepresentedLeg(AtJoints(), motion) == Approx(kLeg_m).epsilon(0.01));
    const auto estimate = core::EstimateLegLength(Mixed().set, MarkersOf(Mixed(), motion));
    REQUIRE(estimate.ok());
    least_estimate = std::min(least_estimate, *estimate);
  }
  CHECK(least_estimate < 0.95 * kLeg_m);  // an estimate from the pose would be wrong
}

TEST_CASE("Represent: positions are divided by the leg length of the bones", "[core][motion]") {
  const core::JointMotion motion = RandomPoses(Bones::kFixed).front();
  const auto states = core::Represent(Mixed(), motion, 60, core::kObservation);
  REQUIRE(states.ok());
  const core::FrameMatrix markers = MarkersOf(Mixed(), motion).positions_m;
  CHECK(core::WorldPositions(*states).isApprox(markers, 1e-4F));
  CHECK(states->states(0, 2) == Approx(markers(0, 2) / kLeg_m).epsilon(1e-3));
}

TEST_CASE("Represent: a given leg length replaces that of the bones", "[core][motion]") {
  const auto motion = RandomPoses(GENERATE(Bones::kFixed, Bones::kTranslations)).front();
  const auto states = core::Represent(Mixed(), motion, 60, core::kObservation, 0.5);
  REQUIRE(states.ok());
  CHECK(states->leg_length_m == 0.5);
}

TEST_CASE("SkeletonLegLength: hip to knee to ankle at zero angles", "[core][motion]") {
  for (const core::MarkerScheme& scheme : {AtJoints(), Mixed()}) {
    const auto length = core::SkeletonLegLength(scheme, Legs(Bones::kFixed));
    REQUIRE(length.ok());
    CHECK(*length == Approx(kLeg_m));
  }
}

TEST_CASE("Represent: the leg length of markers at hips, knees and ankles is within 3 %",
          "[core][motion]") {
  const core::MarkerScheme scheme = AtJoints();
  for (const core::JointMotion& motion : RandomPoses(Bones::kFixed)) {
    core::MarkerMotion markers = MarkersOf(scheme, motion);
    constexpr float kNoise_m = 0.005F;
    markers.positions_m +=
        kNoise_m * FixedNumbers(markers.positions_m.rows(), markers.positions_m.cols());
    CHECK(RepresentedLeg(scheme, markers) == Approx(kLeg_m).epsilon(0.03));
  }
}

TEST_CASE("Represent: names the source marker that no frame has", "[core][motion]") {
  core::MarkerMotion motion;
  motion.names = {"lhip", "rhip", "lknee", "rknee", "lfoot", "rfoot"};
  motion.frame_rate_hz = 60;
  motion.positions_m = core::FrameMatrix::Zero(4, 18);
  for (int m = 0; m < 6; ++m) {
    motion.positions_m.col(3 * m + 1).setConstant(m % 2 == 0 ? 0.1F : -0.1F);
    motion.positions_m.col(3 * m + 2).setConstant(0.8F - 0.4F * static_cast<float>(m / 2));
  }
  CHECK(core::Represent(Mixed(), motion, 60, core::GlitchPolicy::kKeep).ok());
  motion.positions_m.middleCols<3>(12).setConstant(std::nanf(""));
  const auto states = core::Represent(Mixed(), motion, 60, core::GlitchPolicy::kKeep);
  CHECK(states.status().message() == "'lfoot' is missing in all 4 frames, so marker 'LKnee' is");
}

TEST_CASE("Represent: hips above each other are a sign of wrong axes", "[core][motion]") {
  core::MarkerMotion motion;
  motion.names = {"lhip", "rhip", "lknee", "rknee", "lfoot", "rfoot"};
  motion.frame_rate_hz = 60;
  motion.positions_m = core::FrameMatrix::Zero(4, 18);
  for (int m = 0; m < 6; ++m) {
    motion.positions_m.col(3 * m + 2).setConstant(m % 2 == 0 ? 0.1F : -0.1F);
    motion.positions_m.col(3 * m).setConstant(0.8F - 0.4F * static_cast<float>(m / 2));
  }
  const auto states = core::Represent(AtJoints(), motion, 60, core::kObservation);
  CHECK_THAT(std::string(states.status().message()), Catch::Contains("--up-axis"));
}

}  // namespace motiondb::tests::leg_length_test
