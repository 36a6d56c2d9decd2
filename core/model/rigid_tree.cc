#include "core/model/rigid_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr int kMaxClips = 64;
constexpr int kFramesOfClip = 16;
constexpr double kMaxDeviation = 0.01;  // of a bone's length, leg lengths
constexpr float kNoLength = 1e-6F;      // leg lengths

// Returns the variance within clips of the distance of each pair of markers (leg lengths squared).
Eigen::MatrixXd DistanceVariances(const ModelParts& parts) {
  const Eigen::Index count = parts.marker_set.marker_count();
  Eigen::MatrixXd variances = Eigen::MatrixXd::Zero(count, count);
  int frames = 0;
  const auto clips = std::min<std::size_t>(kMaxClips, parts.clips.size());
  for (std::size_t i = 0; i < clips; ++i) {
    const ModelClip& clip = parts.clips[i * parts.clips.size() / clips];
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
    Eigen::MatrixXd squares = sum;
    const int sampled = std::min(kFramesOfClip, clip.frame_count);
    for (int f = 0; f < sampled; ++f) {
      const int frame = clip.first_frame + f * clip.frame_count / sampled;
      const Eigen::RowVectorXf state = parts.states.row(frame).cwiseProduct(parts.scale.divisor);
      for (Eigen::Index a = 0; a < count; ++a) {
        for (Eigen::Index b = 0; b < a; ++b) {
          const double distance = (state.segment<3>(6 * a) - state.segment<3>(6 * b)).norm();
          sum(a, b) += distance;
          squares(a, b) += distance * distance;
        }
      }
    }
    variances += squares - sum.cwiseAbs2() / sampled;
    frames += sampled;
  }
  variances /= std::max(1, frames);
  return variances.selfadjointView<Eigen::Lower>();
}

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
  const Eigen::MatrixXd variances = DistanceVariances(parts);
  const int count = parts.marker_set.marker_count();
  // Prim's algorithm.
  RigidTree tree;
  std::vector<int> parent(count, -1);
  std::vector<double> best(count, std::numeric_limits<double>::infinity());
  std::vector<bool> is_connected(count, false);
  for (int next = std::max(0, parts.marker_set.landmarks.left_hip); next >= 0;) {
    is_connected[next] = true;
    tree.bones.push_back({next, best[next] <= kMaxDeviation * kMaxDeviation ? parent[next] : -1});
    for (int m = 0; m < count; ++m) {
      if (!is_connected[m] && variances(m, next) < best[m]) {
        best[m] = variances(m, next);
        parent[m] = next;
      }
    }
    next = -1;
    for (int m = 0; m < count; ++m) {
      if (!is_connected[m] && (next < 0 || best[m] < best[next])) next = m;
    }
  }
  return tree;
}

}  // namespace motiondb::core
