#include "import/npz/sampled_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::importer {
namespace {

using core::Dof;

constexpr double kStill_m = 1e-9;  // a smaller change of position is rounding

using SampledOrder = std::array<int, 3>;  // 0 x, 1 y, 2 z; the leftmost rotation first
constexpr std::array<SampledOrder, 3> kSampledOrders = {{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}};

std::array<Eigen::Vector3d, 3> SampledAxes(const SampledOrder& order) {
  return {Eigen::Vector3d::Unit(order[0]), Eigen::Vector3d::Unit(order[1]),
          Eigen::Vector3d::Unit(order[2])};
}

// What one pass over the frames of a joint shows.
struct SampledSummary {
  SampledOrder order = {};
  bool moves = false;
  Eigen::Vector3d first_position_m = Eigen::Vector3d::Zero();
};

// Gimbal lock: the first and last axis become parallel. Chooses the order furthest from it.
SampledSummary Summarize(const SampledJoint& joint, int j, Eigen::Index frames,
                         const SampledPose& pose) {
  SampledSummary summary;
  summary.first_position_m = pose(j, 0).translation();
  std::array<double, kSampledOrders.size()> nearest_lock{};  // maximum cosine between the two axes
  for (Eigen::Index frame = 0; frame < frames; ++frame) {
    const Eigen::Isometry3d local = pose(j, frame);
    const Eigen::Matrix3d turn = joint.rest_rotation.transpose() * local.linear();
    for (std::size_t k = 0; k < kSampledOrders.size(); ++k) {
      nearest_lock[k] =
          std::max(nearest_lock[k], std::abs(turn(kSampledOrders[k][0], kSampledOrders[k][2])));
    }
    summary.moves |= !((local.translation() - summary.first_position_m).norm() <= kStill_m);
  }
  const auto* best = std::min_element(nearest_lock.begin(), nearest_lock.end());
  summary.order = kSampledOrders[static_cast<std::size_t>(best - nearest_lock.begin())];
  summary.moves |= joint.parent < 0;
  return summary;
}

core::Joint JointOfSample(const SampledJoint& sampled, const SampledSummary& summary) {
  core::Joint joint{.name = sampled.name,
                    .parent = sampled.parent,
                    .offset_m = summary.moves ? sampled.offset_m : summary.first_position_m,
                    .pre_rotation = sampled.rest_rotation};
  for (int axis = 0; summary.moves && axis < 3; ++axis) {
    joint.dofs.push_back({.kind = Dof::Kind::kTranslation, .axis = Eigen::Vector3d::Unit(axis)});
  }
  for (const Eigen::Vector3d& axis : SampledAxes(summary.order)) {
    joint.dofs.push_back({.kind = Dof::Kind::kRotation, .axis = axis});
  }
  return joint;
}

}  // namespace

absl::StatusOr<core::JointMotion> MotionOfSamples(std::string name,
                                                  const std::vector<SampledJoint>& joints,
                                                  Eigen::Index frames, double frame_rate_hz,
                                                  const SampledPose& pose) {
  std::vector<SampledSummary> summaries;
  std::vector<core::Joint> built;
  for (const SampledJoint& joint : joints) {
    summaries.push_back(Summarize(joint, static_cast<int>(built.size()), frames, pose));
    built.push_back(JointOfSample(joint, summaries.back()));
  }
  MOTIONDB_ASSIGN_OR_RETURN(core::Skeleton skeleton,
                            core::Skeleton::Create(std::move(name), std::move(built)));
  core::JointMotion motion{.skeleton = std::make_shared<const core::Skeleton>(std::move(skeleton)),
                           .frame_rate_hz = frame_rate_hz,
                           .angles = {}};
  motion.angles.resize(frames, motion.skeleton->dof_count());
  for (int j = 0; j < motion.skeleton->joint_count(); ++j) {
    const core::Joint& joint = motion.skeleton->joints()[j];
    const std::array<Eigen::Vector3d, 3> axes = SampledAxes(summaries[j].order);
    Eigen::Vector3d previous = Eigen::Vector3d::Zero();
    for (Eigen::Index frame = 0; frame < frames; ++frame) {
      const Eigen::Isometry3d local = pose(j, frame);
      int column = motion.skeleton->first_dof(j);
      if (summaries[j].moves) {
        motion.angles.block<1, 3>(frame, column) =
            (local.translation() - joint.offset_m).transpose();
        column += 3;
      }
      previous =
          core::AnglesAboutAxes(joint.pre_rotation.transpose() * local.linear(), axes, previous);
      motion.angles.block<1, 3>(frame, column) = previous.transpose();
    }
  }
  return motion;
}

}  // namespace motiondb::importer
