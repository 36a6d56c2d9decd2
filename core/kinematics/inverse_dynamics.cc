#include "core/kinematics/inverse_dynamics.h"

#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

// Rotation vector from one orientation to another, in the axes of both.
Eigen::Vector3d TurnBetween(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(from.linear()).conjugate() *
                               Eigen::Quaterniond(to.linear()));
  return turn.angle() * turn.axis();
}

}  // namespace

std::vector<Wrench> LinkWrenches(std::span<const LinkInertia> links, const JointPoses& before,
                                 const JointPoses& at, const JointPoses& after, double rate_hz) {
  std::vector<Wrench> wrenches(links.size());
  for (std::size_t j = 0; j < links.size(); ++j) {
    const LinkInertia& link = links[j];
    if (!(link.mass_kg > 0)) continue;
    const Eigen::Vector3d centre = at[j] * link.centre_m;
    const Eigen::Vector3d acceleration =
        (before[j] * link.centre_m - 2 * centre + after[j] * link.centre_m) * rate_hz * rate_hz;
    wrenches[j].force = link.mass_kg * (acceleration + kGravity * Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d velocity_before = rate_hz * TurnBetween(before[j], at[j]);
    const Eigen::Vector3d velocity_after = rate_hz * TurnBetween(at[j], after[j]);
    const Eigen::Vector3d velocity = (velocity_before + velocity_after) / 2;
    const Eigen::Vector3d own_moment =
        link.inertia_kg_m2 * (velocity_after - velocity_before) * rate_hz +
        velocity.cross(link.inertia_kg_m2 * velocity);
    wrenches[j].moment = at[j].linear() * own_moment + centre.cross(wrenches[j].force);
  }
  return wrenches;
}

Eigen::RowVectorXd JointEfforts(const Skeleton& skeleton,
                                const Eigen::Ref<const Eigen::RowVectorXd>& angles,
                                const JointPoses& poses, std::vector<Wrench> wrenches) {
  std::vector<Eigen::Vector3d> axes(static_cast<std::size_t>(skeleton.dof_count()));
  WorldDofAxes(skeleton, angles, poses, axes);
  Eigen::RowVectorXd efforts(skeleton.dof_count());
  for (int j = skeleton.joint_count() - 1; j >= 0; --j) {
    const Joint& joint = skeleton.joints()[j];
    const Wrench& wrench = wrenches[j];
    const Eigen::Vector3d moment =
        wrench.moment - poses[j].translation().cross(wrench.force);  // about the joint
    for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
      const int c = skeleton.first_dof(j) + static_cast<int>(k);
      const bool turns = joint.dofs[k].kind == Dof::Kind::kRotation;
      efforts[c] = axes[c].dot(turns ? moment : wrench.force);
    }
    if (joint.parent >= 0) wrenches[joint.parent] += wrench;
  }
  return efforts;
}

}  // namespace motiondb::core
