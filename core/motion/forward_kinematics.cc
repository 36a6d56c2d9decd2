#include "core/motion/forward_kinematics.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace motiondb::core {

namespace {

// Computes the pose of a joint whose parent's pose is known.
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

FrameMatrix JointRotations(const JointMotion& motion) {
  const Skeleton& skeleton = *motion.skeleton;
  std::vector<Eigen::Isometry3d> world_from_joint(skeleton.joint_count());
  FrameMatrix rotations(motion.angles.rows(), 4 * skeleton.joint_count());
  for (Eigen::Index frame = 0; frame < rotations.rows(); ++frame) {
    ForwardKinematics(skeleton, motion.angles.row(frame), world_from_joint);
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      const Eigen::Quaterniond rotation(world_from_joint[j].linear());
      auto row = rotations.block<1, 4>(frame, 4 * j);
      row = rotation.coeffs().transpose().cast<float>();
      if (frame > 0 && row.dot(rotations.block<1, 4>(frame - 1, 4 * j)) < 0) row = -row;
    }
  }
  return rotations;
}

namespace {

// Gimbal lock: below this cosine of the second angle, the first and third angles are ambiguous.
constexpr double kLock = 1e-9;

double NearestTurn(double angle, double previous) {
  return previous + std::remainder(angle - previous, 2 * std::numbers::pi);
}

// m = Rx(q0) Ry(q1) Rz(q2) with q2 known.
Eigen::Vector3d WithThird(const Eigen::Matrix3d& m, double third, const Eigen::Vector3d& previous) {
  const Eigen::Matrix3d rest = m * Eigen::AngleAxisd(-third, Eigen::Vector3d::UnitZ());
  return {NearestTurn(std::atan2(rest(2, 1), rest(1, 1)), previous[0]),
          NearestTurn(std::atan2(rest(0, 2), rest(0, 0)), previous[1]),
          NearestTurn(third, previous[2])};
}

}  // namespace

Eigen::Vector3d AnglesAboutAxes(const Eigen::Matrix3d& rotation,
                                const std::array<Eigen::Vector3d, 3>& axes,
                                const Eigen::Vector3d& previous) {
  // In a right-handed frame of the axes the rotation is Rx Ry Rz. If the third axis points the
  // other way, its angle changes sign.
  const double hand = axes[0].cross(axes[1]).dot(axes[2]) < 0 ? -1 : 1;
  Eigen::Matrix3d frame;
  frame << axes[0], axes[1], hand * axes[2];
  const Eigen::Matrix3d m = frame.transpose() * rotation * frame;
  const Eigen::Vector3d before(previous[0], previous[1], hand * previous[2]);

  Eigen::Vector3d angles;
  if (std::hypot(m(0, 0), m(0, 1)) < kLock) {
    angles = WithThird(m, before[2], before);
  } else {
    const double third = std::atan2(-m(0, 1), m(0, 0));
    angles = WithThird(m, third, before);
    const Eigen::Vector3d other = WithThird(m, third + std::numbers::pi, before);
    if ((other - before).squaredNorm() < (angles - before).squaredNorm()) angles = other;
  }
  angles[2] *= hand;
  return angles;
}

Eigen::Quaterniond ShortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

}  // namespace motiondb::core
