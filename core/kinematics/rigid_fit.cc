#include "core/kinematics/rigid_fit.h"

#include <Eigen/SVD>
#include <cassert>

namespace motiondb::core {

Eigen::Isometry3d FitRigid(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to,
                           const Eigen::VectorXd& weights) {
  assert(from.cols() == to.cols() && from.cols() == weights.size());
  Eigen::Isometry3d fit = Eigen::Isometry3d::Identity();
  const double total = weights.sum();
  if (!(total > 0)) return fit;
  const Eigen::Vector3d from_centre = from * weights / total;
  const Eigen::Vector3d to_centre = to * weights / total;
  Eigen::Matrix3d covariance = (to.colwise() - to_centre) * weights.asDiagonal() *
                               (from.colwise() - from_centre).transpose();
  // What the points leave open is pulled towards no turn.
  covariance.diagonal().array() += 1e-6 * covariance.norm();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  fit.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  fit.translation() = to_centre - fit.linear() * from_centre;
  return fit;
}

}  // namespace motiondb::core
