// The singularity-robust (SR) inverse of Nakamura and Hanafusa (1986): least squares whose damping
// is nothing where the equations tell the unknowns well and grows as they cease to.
// Thread-compatible: one object a thread.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace motiondb::core {

// Solves J x = r for x in the sense of damped least squares. The paper [16] damps all unknowns
// alike by the manipulability w = sqrt(det(J^T J)): by k (1 - w / w0)^2 where w < w0. A body always
// has unknowns that its markers do not tell, such as a thumb's, and one such would damp all. So
// here each pivot of the factorisation of J^T J (w^2 is their product) is damped by the same rule:
// an unknown is damped only if, given those before it, nothing tells it.
//
// Unknowns go from the root of a tree to its leaves. The factorisation begins at the leaves, which
// leaves what is zero in J^T J zero: two limbs share only what carries both.
class SingularityRobustInverse {
 public:
  explicit SingularityRobustInverse(int unknowns);

  // No equations, nothing held.
  void Clear();
  // Three equations: columns (3 x n) of J at the n unknowns, ascending; all other columns are zero.
  // Their squared error counts `weight` times.
  void Add(std::span<const int> unknowns, const Eigen::Ref<const Eigen::Matrix3Xd>& columns,
           const Eigen::Vector3d& right_side, double weight = 1);
  // One equation an unknown, x = right_side, whose squared error counts `weight` times.
  void AddPull(const Eigen::VectorXd& right_side, double weight);
  // J^T r: the direction in which x reduces the error fastest.
  const Eigen::VectorXd& gradient() const { return gradient_; }

  // This unknown is to be `value`, whatever the equations say.
  void Hold(int unknown, double value);
  bool IsHeld(int unknown) const { return held_[unknown]; }
  // Nothing is held any more.
  void Release();

  // The solution with `damping` added to the diagonal of J^T J. Valid until the next call. Takes no
  // memory.
  const Eigen::VectorXd& Solve(double damping = 0);

 private:
  void Factorise(double damping);

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> normal_;  // lower half
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> factor_;
  Eigen::VectorXd gradient_;
  Eigen::VectorXd solution_;
  std::vector<bool> held_;
  Eigen::VectorXd held_at_;            // 0 where not held
  std::vector<std::vector<int>> row_;  // of each unknown: the earlier ones it is coupled to
};

}  // namespace motiondb::core
