#include "core/view/bones.h"

#include <algorithm>

#include "core/model/even_spread.h"
#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr int kBoneFrames = 256;  // of a motion

}  // namespace

std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const DistanceSpread& spread) {
  const Eigen::MatrixXd costs =
      spread.Variances().cwiseMax(0).cwiseSqrt() + kLengthCost * spread.Means();
  std::vector<BoneEnds> bones;
  for (const auto& [marker, parent] : SpanningTree(costs, std::max(0, set.landmarks.left_hip))) {
    if (parent >= 0) bones.emplace_back(parent, marker);
  }
  return bones;
}

std::vector<BoneEnds> MarkerBones(const Model& model) {
  return MarkerBones(model.marker_set(), SpreadOfClips(model.parts()));
}

std::vector<BoneEnds> MarkerBones(const MarkerSet& set, const StateSequence& states) {
  DistanceSpread spread(set.marker_count());
  spread.Add(states.states(SpreadEvenly(states.frame_count(), kBoneFrames), Eigen::all));
  return MarkerBones(set, spread);
}

std::vector<BoneEnds> MarkerBonesOf(const MarkerSet& set, const Skeleton& skeleton) {
  std::vector<int> marker_of_joint(skeleton.joint_count(), -1);
  for (int m = 0; m < set.marker_count(); ++m) {
    const int joint = skeleton.FindJoint(set.markers[m]);
    if (joint < 0) return {};
    marker_of_joint[joint] = m;
  }
  std::vector<BoneEnds> bones;
  std::vector<int> nearest(skeleton.joint_count(), -1);  // marker of the joint or an ancestor
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.joints()[joint].parent;
    const int above = parent < 0 ? -1 : nearest[parent];
    const int marker = marker_of_joint[joint];
    nearest[joint] = marker < 0 ? above : marker;
    if (marker >= 0 && above >= 0) bones.emplace_back(above, marker);
  }
  return bones;
}

std::vector<BoneEnds> JointBones(const Skeleton& skeleton) {
  std::vector<BoneEnds> bones;
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.joints()[joint].parent;
    if (parent >= 0) bones.emplace_back(parent, joint);
  }
  return bones;
}

}  // namespace motiondb::core
