#include "core/model/rigid_tree.h"

#include <algorithm>

#include "core/model/distance_spread.h"
#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr double kMaxDeviation = 0.01;  // of a bone's length, leg lengths
constexpr float kNoLength = 1e-6F;      // leg lengths

}  // namespace

Eigen::RowVectorXf RigidTree::Restore(const Eigen::RowVectorXf& positions,
                                      const Eigen::RowVectorXf& reference) const {
  Eigen::RowVectorXf restored = positions;
  for (const Bone& bone : bones) {
    if (bone.parent < 0) continue;
    const Eigen::RowVector3f along =
        positions.segment<3>(3 * bone.marker) - positions.segment<3>(3 * bone.parent);
    const float length =
        (reference.segment<3>(3 * bone.marker) - reference.segment<3>(3 * bone.parent)).norm();
    const float predicted = along.norm();
    restored.segment<3>(3 * bone.marker) = restored.segment<3>(3 * bone.parent);
    if (predicted > kNoLength) {
      restored.segment<3>(3 * bone.marker) += along * (length / predicted);
    }
  }
  return restored;
}

RigidTree FindRigidTree(const ModelParts& parts) {
  const Eigen::MatrixXd variances = SpreadOfClips(parts).Variances();
  RigidTree tree;
  for (const auto& [marker, parent] :
       SpanningTree(variances, std::max(0, parts.marker_set.landmarks.left_hip))) {
    const bool is_rigid = parent >= 0 && variances(marker, parent) <= kMaxDeviation * kMaxDeviation;
    tree.bones.push_back({marker, is_rigid ? parent : -1});
  }
  return tree;
}

}  // namespace motiondb::core
