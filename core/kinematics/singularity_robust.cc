#include "core/kinematics/singularity_robust.h"

#include <algorithm>
#include <cmath>

namespace motiondb::core {
namespace {

// An unknown is damped if it moves the markers by less than this (m for each rad or m, root of the
// sum of squares over markers).
constexpr double kWeakManipulability = 0.01;
// Damping of an unknown that moves no marker (m^2): as if it moved one marker by 3 mm.
constexpr double kDamping = 1e-5;

double Damped(double pivot) {
  const double manipulability = std::sqrt(std::max(0.0, pivot));
  if (manipulability >= kWeakManipulability) return pivot;
  const double lack = 1 - manipulability / kWeakManipulability;
  return std::max(0.0, pivot) + kDamping * lack * lack;
}

}  // namespace

SingularityRobustInverse::SingularityRobustInverse(int unknowns)
    : normal_(unknowns, unknowns),
      factor_(unknowns, unknowns),
      gradient_(unknowns),
      solution_(unknowns),
      held_(static_cast<std::size_t>(unknowns)),
      held_at_(unknowns),
      row_(static_cast<std::size_t>(unknowns)) {
  for (auto& row : row_) row.reserve(static_cast<std::size_t>(unknowns));
  Clear();
}

void SingularityRobustInverse::Clear() {
  normal_.setZero();
  gradient_.setZero();
  Release();
}

void SingularityRobustInverse::Release() {
  held_.assign(held_.size(), false);
  held_at_.setZero();
}

void SingularityRobustInverse::Hold(int unknown, double value) {
  held_[unknown] = true;
  held_at_[unknown] = value;
}

void SingularityRobustInverse::Add(std::span<const int> unknowns,
                                   const Eigen::Ref<const Eigen::Matrix3Xd>& columns,
                                   const Eigen::Vector3d& right_side, double weight) {
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Eigen::Vector3d column = weight * columns.col(static_cast<Eigen::Index>(i));
    gradient_[unknowns[i]] += column.dot(right_side);
    double* row = normal_.data() + unknowns[i] * normal_.cols();
    for (std::size_t j = 0; j <= i; ++j) {
      row[unknowns[j]] += column.dot(columns.col(static_cast<Eigen::Index>(j)));
    }
  }
}

void SingularityRobustInverse::AddPull(const Eigen::VectorXd& right_side, double weight) {
  normal_.diagonal().array() += weight;
  gradient_ += weight * right_side;
}

// J^T J = L^T D L, L unit lower triangular; factor_ holds L below the diagonal and D on it.
void SingularityRobustInverse::Factorise(double damping) {
  factor_ = normal_;
  for (int k = static_cast<int>(gradient_.size()); k-- > 0;) {
    std::vector<int>& row = row_[k];
    row.clear();
    if (held_[k]) continue;
    const double pivot = Damped(factor_(k, k) + damping);
    factor_(k, k) = pivot;
    for (int i = 0; i < k; ++i) {
      if (factor_(k, i) != 0 && !held_[i]) row.push_back(i);
    }
    const double* coupling = factor_.data() + k * factor_.cols();
    for (std::size_t a = 0; a < row.size(); ++a) {
      const double share = coupling[row[a]] / pivot;
      double* target = factor_.data() + row[a] * factor_.cols();
      for (std::size_t b = 0; b <= a; ++b) target[row[b]] -= share * coupling[row[b]];
    }
    for (const int i : row) factor_(k, i) /= pivot;
  }
}

const Eigen::VectorXd& SingularityRobustInverse::Solve(double damping) {
  Factorise(damping);
  const int count = static_cast<int>(gradient_.size());
  solution_ = gradient_;
  for (int k = 0; k < count; ++k) {  // held unknowns move to the right side
    if (held_at_[k] == 0) continue;
    for (int i = 0; i < count; ++i) {
      solution_[i] -= normal_(std::max(i, k), std::min(i, k)) * held_at_[k];
    }
  }
  for (int k = count; k-- > 0;) {
    if (held_[k]) solution_[k] = held_at_[k];
    for (const int i : row_[k]) solution_[i] -= factor_(k, i) * solution_[k];
  }
  for (int k = 0; k < count; ++k) {
    if (held_[k]) continue;
    solution_[k] /= factor_(k, k);
    for (const int i : row_[k]) solution_[k] -= factor_(k, i) * solution_[i];
  }
  return solution_;
}

}  // namespace motiondb::core
