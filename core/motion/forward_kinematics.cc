#include "core/motion/forward_kinematics.h"

#include <cassert>

namespace motiondb::core {
namespace {

// Of a joint whose parent is in its place.
void PlaceJoint(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles, int j,
                std::span<Eigen::Isometry3d> world_from_joint) {
  const Joint& joint = skeleton.joints()[j];
  const std::span<const double> q(angles.data() + skeleton.first_dof(j), joint.dofs.size());
  const Eigen::Isometry3d parent_from_joint = ParentFromJoint(joint, q);
  world_from_joint[j] =
      joint.parent < 0 ? parent_from_joint : world_from_joint[joint.parent] * parent_from_joint;
}

}  // namespace

Eigen::Isometry3d ParentFromJoint(const Joint& joint, std::span<const double> q) {
  assert(q.size() == joint.dofs.size());
  Eigen::Vector3d translation = joint.offset_m;
  Eigen::Matrix3d rotation = joint.pre_rotation;
  for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
    const Dof& dof = joint.dofs[k];
    if (dof.kind == Dof::Kind::kTranslation) {
      translation += q[k] * dof.axis;
    } else {
      rotation *= Eigen::AngleAxisd(q[k], dof.axis).toRotationMatrix();
    }
  }
  Eigen::Isometry3d parent_from_joint;
  parent_from_joint.linear() = rotation * joint.post_rotation;
  parent_from_joint.translation() = translation;
  parent_from_joint.makeAffine();
  return parent_from_joint;
}

void ForwardKinematics(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                       std::span<Eigen::Isometry3d> world_from_joint) {
  assert(angles.size() == skeleton.dof_count());
  assert(static_cast<int>(world_from_joint.size()) == skeleton.joint_count());
  for (int j = 0; j < skeleton.joint_count(); ++j)
    PlaceJoint(skeleton, angles, j, world_from_joint);
}

void ForwardKinematics(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                       std::span<const int> joints, std::span<Eigen::Isometry3d> world_from_joint) {
  assert(angles.size() == skeleton.dof_count());
  assert(static_cast<int>(world_from_joint.size()) == skeleton.joint_count());
  for (const int j : joints) PlaceJoint(skeleton, angles, j, world_from_joint);
}

std::vector<Eigen::Isometry3d> ForwardKinematics(
    const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles) {
  std::vector<Eigen::Isometry3d> world_from_joint(skeleton.joint_count());
  ForwardKinematics(skeleton, angles, world_from_joint);
  return world_from_joint;
}

void WorldDofAxes(const Skeleton& skeleton, const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                  std::span<const Eigen::Isometry3d> world_from_joint,
                  std::span<Eigen::Vector3d> axes) {
  assert(static_cast<int>(axes.size()) == skeleton.dof_count());
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const Joint& joint = skeleton.joints()[j];
    if (joint.dofs.empty()) continue;
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    if (joint.parent >= 0) rotation = world_from_joint[joint.parent].linear();
    bool turned = false;
    int column = skeleton.first_dof(j);
    for (const Dof& dof : joint.dofs) {
      if (dof.kind == Dof::Kind::kRotation && !turned) {
        rotation *= joint.pre_rotation;
        turned = true;
      }
      axes[column] = rotation * dof.axis;
      const bool last = &dof == &joint.dofs.back();
      if (turned && !last) {
        rotation *= Eigen::AngleAxisd(angles[column], dof.axis).toRotationMatrix();
      }
      ++column;
    }
  }
}

FrameMatrix JointPositions(const JointMotion& motion) {
  const Skeleton& skeleton = *motion.skeleton;
  std::vector<Eigen::Isometry3d> world_from_joint(skeleton.joint_count());
  FrameMatrix positions(motion.angles.rows(), 3 * skeleton.joint_count());
  for (Eigen::Index frame = 0; frame < positions.rows(); ++frame) {
    ForwardKinematics(skeleton, motion.angles.row(frame), world_from_joint);
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      positions.block<1, 3>(frame, 3 * j) =
          world_from_joint[j].translation().transpose().cast<float>();
    }
  }
  return positions;
}

}  // namespace motiondb::core
