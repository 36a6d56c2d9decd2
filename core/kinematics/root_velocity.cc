#include "core/kinematics/root_velocity.h"

#include <cassert>

namespace motiondb::core {

RootVelocity SolveRootVelocity(const MarkerKinematics& kinematics, const MarkerPose& pose,
                               const Eigen::Ref<const Eigen::RowVectorXf>& velocities,
                               SingularityRobustInverse& inverse) {
  inverse.Clear();
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    const Eigen::Vector3d velocity = velocities.segment<3>(3 * m).transpose().cast<double>();
    if (!velocity.allFinite()) continue;
    const auto coordinates = kinematics.Coordinates(m);
    inverse.Add(coordinates,
                pose.jacobian.middleCols(kinematics.first_column(m),
                                         static_cast<Eigen::Index>(coordinates.size())),
                velocity);
  }
  const Eigen::VectorXd& rates = inverse.Solve();
  RootVelocity root;
  const Joint& joint = kinematics.skeleton()->joints().front();
  for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
    Eigen::Vector3d& part =
        joint.dofs[k].kind == Dof::Kind::kTranslation ? root.linear : root.angular;
    part += rates[static_cast<Eigen::Index>(k)] * pose.axes[k];
  }
  return root;
}

PlanarVelocity RootVelocityFromHips(const MarkerSet& set,
                                    const Eigen::Ref<const Eigen::RowVectorXf>& state) {
  const Landmarks& hips = set.landmarks;
  assert(hips.left_hip >= 0 && hips.right_hip >= 0 && state.size() == set.dimension_count());
  const auto on_floor = [&state](Eigen::Index column) -> Eigen::Vector2d {
    return state.segment<2>(column).transpose().cast<double>();
  };
  const Eigen::Index left = 6 * hips.left_hip;
  const Eigen::Index right = 6 * hips.right_hip;
  const Eigen::Vector2d across = on_floor(left) - on_floor(right);
  const Eigen::Vector2d left_velocity = on_floor(left + 3);
  const Eigen::Vector2d right_velocity = on_floor(right + 3);
  const Eigen::Vector2d turning = left_velocity - right_velocity;
  const Eigen::Vector2d moving = 0.5 * (left_velocity + right_velocity);
  PlanarVelocity velocity{.x = moving.x(), .y = moving.y()};
  if (across.squaredNorm() != 0) {
    velocity.yaw_rate =
        (across.x() * turning.y() - across.y() * turning.x()) / across.squaredNorm();
  }
  return velocity;
}

}  // namespace motiondb::core
