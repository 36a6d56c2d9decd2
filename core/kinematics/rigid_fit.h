// The rigid motion that brings points nearest to others. Safe to call from any thread.
#pragma once

#include <Eigen/Geometry>

namespace motiondb::core {

// The isometry that minimises the weighted sum of squared distances from each moved column of
// `from` to that of `to` (Kabsch; weights not negative). Where points on a line or a single one
// leave a turn open, it turns as little as it can. Columns of weight 0 may hold anything finite.
Eigen::Isometry3d FitRigid(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to,
                           const Eigen::VectorXd& weights);

}  // namespace motiondb::core
