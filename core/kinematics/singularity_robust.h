// The singularity-robust (SR) inverse of Nakamura and Hanafusa (1986): least squares with damping
// that is zero for well-determined unknowns and grows near singularities.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace motiondb::core {

// Solves J x = r by damped least squares. The paper [16] damps all unknowns by k (1 - w / w0)^2 if
// the manipulability w = sqrt(det(J^T J)) is below w0. A body always has unknowns that no marker
// determines, such as a thumb's; one of them would damp all. So here the same rule applies to each
// pivot of the factorisation of J^T J (w^2 is their product): an unknown is damped only if, given
// those before it, it is undetermined.
//
// Unknowns are ordered from root to leaves. The factorisation starts at the leaves and so keeps the
// zeros of J^T J: two limbs share only their common ancestors.
class SingularityRobustInverse {
 public:
  explicit SingularityRobustInverse(int unknowns);

  // Removes all equations and holds.
  void Clear();
  // Adds three equations: columns (3 x n) of J at the n unknowns, ascending; other columns are
  // zero. Their squared error has the factor `weight`.
  void Add(std::span<const int> unknowns, const Eigen::Ref<const Eigen::Matrix3Xd>& columns,
           const Eigen::Vector3d& right_side, double weight = 1);
  // Adds the equation x = right_side for every unknown, with the factor `weight` of the squared
  // error.
  void AddPull(const Eigen::VectorXd& right_side, double weight);
  // J^T r: the direction of steepest descent.
  const Eigen::VectorXd& gradient() const { return gradient_; }

  // Fixes the unknown at `value`.
  void Hold(int unknown, double value);
  bool IsHeld(int unknown) const { return held_[unknown]; }
  // Removes all holds.
  void Release();

  // Returns the solution with `damping` added to the diagonal of J^T J. Valid until the next call.
  // Does not allocate.
  const Eigen::VectorXd& Solve(double damping = 0);

 private:
  void Factorise(double damping);

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> normal_;  // lower triangle
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> factor_;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd solution_;
  std::vector<bool> held_;
  Eigen::VectorXd held_at_;            // 0: not held
  std::vector<std::vector<int>> row_;  // of each unknown: earlier unknowns coupled to it
};

}  // namespace motiondb::core
