#include "core/model/marker_distances.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kMaxSpreadClips = 64;
constexpr int kSpreadFrames = 16;  // of a clip

}  // namespace

DistanceSpread::DistanceSpread(int marker_count)
    : sums_(Eigen::MatrixXd::Zero(marker_count, marker_count)), squares_(sums_) {}

void DistanceSpread::Add(const Eigen::Ref<const FrameMatrix>& states) {
  const Eigen::Index count = sums_.rows();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd squares = sum;
  for (Eigen::Index frame = 0; frame < states.rows(); ++frame) {
    const auto state = states.row(frame);
    for (Eigen::Index a = 0; a < count; ++a) {
      for (Eigen::Index b = 0; b < a; ++b) {
        const double distance = (state.segment<3>(6 * a) - state.segment<3>(6 * b)).norm();
        sum(a, b) += distance;
        squares(a, b) += distance * distance;
      }
    }
  }
  sums_ += sum;
  squares_ +=
      squares - sum.cwiseAbs2() / static_cast<double>(std::max<Eigen::Index>(1, states.rows()));
  frames_ += states.rows();
}

Eigen::MatrixXd DistanceSpread::Means() const {
  const Eigen::MatrixXd means = sums_ / static_cast<double>(std::max<Eigen::Index>(1, frames_));
  return means.selfadjointView<Eigen::Lower>();
}

Eigen::MatrixXd DistanceSpread::Variances() const {
  const Eigen::MatrixXd variances =
      squares_ / static_cast<double>(std::max<Eigen::Index>(1, frames_));
  return variances.selfadjointView<Eigen::Lower>();
}

DistanceSpread SpreadOfClips(const ModelParts& parts) {
  DistanceSpread spread(parts.marker_set.marker_count());
  const auto clips = std::min(kMaxSpreadClips, parts.clips.size());
  for (std::size_t i = 0; i < clips; ++i) {
    const ModelClip& clip = parts.clips[i * parts.clips.size() / clips];
    const int sampled = std::min(kSpreadFrames, clip.frame_count);
    FrameMatrix states(sampled, parts.states.cols());
    for (int f = 0; f < sampled; ++f) {
      const int frame = clip.first_frame + f * clip.frame_count / sampled;
      states.row(f) = parts.states.row(frame).cwiseProduct(parts.scale.divisor);
    }
    spread.Add(states);
  }
  return spread;
}

std::vector<TreeLink> SpanningTree(const Eigen::MatrixXd& costs, int first) {
  const auto count = static_cast<int>(costs.rows());
  std::vector<TreeLink> links;
  std::vector<int> parent(count, -1);
  std::vector<double> best(count, std::numeric_limits<double>::infinity());
  std::vector<bool> is_joined(count, false);
  for (int next = count > 0 ? first : -1; next >= 0;) {
    is_joined[next] = true;
    links.push_back({next, parent[next]});
    for (int node = 0; node < count; ++node) {
      if (!is_joined[node] && costs(node, next) < best[node]) {
        best[node] = costs(node, next);
        parent[node] = next;
      }
    }
    next = -1;
    for (int node = 0; node < count; ++node) {
      if (!is_joined[node] && (next < 0 || best[node] < best[next])) next = node;
    }
  }
  return links;
}

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
