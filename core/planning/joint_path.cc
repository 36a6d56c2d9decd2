#include "core/planning/joint_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/motion/forward_kinematics.h"

namespace motiondb::core {
namespace {

// The three axes of a joint with free rotation, and their first column.
struct FreeRotation {
  std::array<Eigen::Vector3d, 3> axes;
  int column;

  FreeRotation(const Skeleton& skeleton, int joint) {
    const std::vector<Dof>& dofs = skeleton.joints()[joint].dofs;
    const int first = static_cast<int>(dofs.size()) - 3;
    column = skeleton.first_dof(joint) + first;
    for (int i = 0; i < 3; ++i) axes[i] = dofs[first + i].axis;
  }

  Eigen::Quaterniond At(const Eigen::Ref<const Eigen::RowVectorXd>& pose) const {
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    for (int i = 0; i < 3; ++i) turn = turn * Eigen::AngleAxisd(pose[column + i], axes[i]);
    return turn;
  }
};

Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

template <typename Visit>
void ForEachFreeRotation(const MarkerKinematics& kinematics, Visit visit) {
  for (int j = 0; j < kinematics.skeleton()->joint_count(); ++j) {
    if (kinematics.TurnsFreely(j)) visit(FreeRotation(*kinematics.skeleton(), j));
  }
}

}  // namespace

JointMatrix PoseSteps(const MarkerKinematics& kinematics, const JointMatrix& poses) {
  const Eigen::Index steps = poses.rows() - 1;
  JointMatrix differences = poses.bottomRows(steps) - poses.topRows(steps);
  ForEachFreeRotation(kinematics, [&](const FreeRotation& rotation) {
    Eigen::Quaterniond before = rotation.At(poses.row(0));
    for (Eigen::Index t = 0; t < steps; ++t) {
      const Eigen::Quaterniond after = rotation.At(poses.row(t + 1));
      const Eigen::AngleAxisd turn(before.conjugate() * after);  // at most half a turn
      differences.row(t).segment<3>(rotation.column) = turn.angle() * turn.axis().transpose();
      before = after;
    }
  });
  return differences;
}

JointPath::JointPath(const MarkerKinematics& kinematics, JointMatrix poses)
    : kinematics_(kinematics), poses_(std::move(poses)), steps_(PoseSteps(kinematics, poses_)) {}

Eigen::RowVectorXd JointPath::At(double place, const Eigen::RowVectorXd& previous) const {
  const Eigen::Index last = steps_.rows() - 1;
  const Eigen::Index i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(place), 0, last);
  const double f = place - static_cast<double>(i);
  // Cumulative form of the spline: a start pose and shares of three steps. The path continues
  // straight beyond its ends.
  const double shares[] = {(-1 + 3 * f - 3 * f * f + f * f * f) / 6,
                           (1 + 3 * f + 3 * f * f - 2 * f * f * f) / 6, f * f * f / 6};
  const Eigen::Index rows[] = {std::max<Eigen::Index>(i - 1, 0), i, std::min(i + 1, last)};
  Eigen::RowVectorXd pose = poses_.row(i);
  for (int k = 0; k < 3; ++k) pose += shares[k] * steps_.row(rows[k]);
  // The pose is between the control points; rounding must not exceed their limits.
  const auto hull = poses_.middleRows(rows[0], std::min(i + 2, last + 1) - rows[0] + 1);
  pose = pose.cwiseMax(hull.colwise().minCoeff()).cwiseMin(hull.colwise().maxCoeff());
  ForEachFreeRotation(kinematics_, [&](const FreeRotation& rotation) {
    const auto step = [&](int k) {
      return FromRotationVector(shares[k] *
                                steps_.row(rows[k]).segment<3>(rotation.column).transpose());
    };
    const Eigen::Quaterniond turn = rotation.At(poses_.row(i)) * step(0) * step(1) * step(2);
    const Eigen::Vector3d before = previous.segment<3>(rotation.column).transpose();
    pose.segment<3>(rotation.column) =
        AnglesAboutAxes(turn.toRotationMatrix(), rotation.axes, before).transpose();
  });
  return pose;
}

}  // namespace motiondb::core
