#include "tests/bench/body_variation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::tests {
namespace {

enum LimbIndex { kHips, kTrunk, kHead, kLeftArm, kRightArm, kLeftLeg, kRightLeg };

Eigen::Vector3f BoneVector(const Eigen::RowVectorXf& pose, const Bone& bone) {
  return (pose.segment<3>(3 * bone.marker) - pose.segment<3>(3 * bone.parent)).transpose();
}

}  // namespace

absl::StatusOr<std::vector<Bone>> StandardBones(const core::MarkerSet& set) {
  std::string missing;
  const auto index = [&](const std::string& name) {
    const auto at = std::find(set.markers.begin(), set.markers.end(), name);
    if (at == set.markers.end()) missing = name;
    return static_cast<int>(at - set.markers.begin());
  };
  std::vector<Bone> bones;
  const auto add = [&](const std::string& marker, const std::string& parent, int limb) {
    bones.push_back({index(marker), index(parent), limb});
  };
  add("Waist", "Pelvis", kTrunk);
  add("Spine", "Waist", kTrunk);
  add("Neck", "Spine", kTrunk);
  add("Head", "Neck", kHead);
  add("HeadTop", "Head", kHead);
  for (const bool left : {true, false}) {
    const std::string side = left ? "L" : "R";
    const int arm = left ? kLeftArm : kRightArm;
    const int leg = left ? kLeftLeg : kRightLeg;
    add(side + "Hip", "Pelvis", kHips);
    add(side + "Clavicle", "Neck", kTrunk);
    add(side + "Shoulder", "Neck", kTrunk);
    for (const auto& [marker, parent] : {std::pair("UpperArm", "Shoulder"),
                                         {"Elbow", "Shoulder"},
                                         {"Forearm", "Elbow"},
                                         {"Wrist", "Elbow"},
                                         {"Hand", "Wrist"}}) {
      add(side + marker, side + parent, arm);
    }
    for (const auto& [marker, parent] : {std::pair("Thigh", "Hip"),
                                         {"Knee", "Hip"},
                                         {"Shin", "Knee"},
                                         {"Ankle", "Knee"},
                                         {"Heel", "Ankle"},
                                         {"Toe", "Ankle"}}) {
      add(side + marker, side + parent, leg);
    }
  }
  if (!missing.empty()) {
    return core::InvalidArgument("marker set '{}': expected a marker '{}'", set.name, missing);
  }
  return bones;
}

Wave::Wave(core::SeededSequence& random) {
  for (int i = 0; i < 3; ++i) {
    cycles_per_second_[i] = random.Between(0.05, 0.4);
    phase_[i] = random.Next();
  }
}

double Wave::At(double seconds) const {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    sum += std::sin(2 * std::numbers::pi * (cycles_per_second_[i] * seconds + phase_[i]));
  }
  return sum / 3;
}

BodyVariation::BodyVariation(std::vector<Bone> bones, const Eigen::RowVectorXf& usual,
                             const Eigen::RowVectorXf& other, core::SeededSequence& random)
    : bones_(std::move(bones)), limbs_(kLimbs) {
  const double upper_body = random.Between(0.88, 1.12);
  const double posture = random.Between(0, 0.3);
  for (int l = 0; l < kLimbs; ++l) {
    Limb& limb = limbs_[l];
    // Legs hardly vary: they define the subject's size, and feet must stay on the floor.
    const bool leg = l == kLeftLeg || l == kRightLeg;
    limb.size = static_cast<float>(leg ? random.Between(0.99, 1.01)
                                       : upper_body * random.Between(0.97, 1.03));
    limb.reach = static_cast<float>(random.Between(0.9, 1.1));
    limb.sway_rad = leg ? 0.03f : l == kHips ? 0.0f : 0.12f;
    for (int axis = 0; axis < 3; ++axis) limb.sway.emplace_back(random);
  }
  lean_.resize(3, static_cast<Eigen::Index>(bones_.size()));
  for (std::size_t b = 0; b < bones_.size(); ++b) {
    const Eigen::Vector3f mean = BoneVector(usual, bones_[b]);
    lean_.col(static_cast<Eigen::Index>(b)) =
        static_cast<float>(posture) * (BoneVector(other, bones_[b]) - mean) +
        (1 - limbs_[bones_[b].limb].reach) * mean;
  }
}

void BodyVariation::Apply(double seconds, Eigen::RowVectorXf& pose,
                          Eigen::RowVectorXf& scratch) const {
  Eigen::Matrix<float, 3, kLimbs> turns;
  for (int l = 0; l < kLimbs; ++l) {
    for (int axis = 0; axis < 3; ++axis) {
      turns(axis, l) = limbs_[l].sway_rad * static_cast<float>(limbs_[l].sway[axis].At(seconds));
    }
  }
  scratch = pose;
  for (std::size_t b = 0; b < bones_.size(); ++b) {
    const Limb& limb = limbs_[bones_[b].limb];
    const Eigen::Vector3f bone = BoneVector(scratch, bones_[b]);
    Eigen::Vector3f varied = limb.reach * bone + lean_.col(static_cast<Eigen::Index>(b));
    varied += turns.col(bones_[b].limb).cross(varied);
    const float length = std::max(varied.norm(), 1e-6f);
    varied *= limb.size * bone.norm() / length;
    pose.segment<3>(3 * bones_[b].marker) =
        pose.segment<3>(3 * bones_[b].parent) + varied.transpose();
  }
}

}  // namespace motiondb::tests
