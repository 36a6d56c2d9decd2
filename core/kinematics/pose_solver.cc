#include "core/kinematics/pose_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace motiondb::core {
namespace {

constexpr double kLargestTurn = 0.5;     // rad in one step, so that the linear model holds
constexpr double kEnoughGain = 1e-6;     // share of the sum of squares below which a descent ends
constexpr double kPrecise = 1e-12;       // m^2 for each marker, single precision's own
constexpr double kFirstDamping = 1e-4;   // m^2, where a step went wrong
constexpr double kLargestDamping = 1e4;  // where no step helps any more
constexpr int kLimitRounds = 8;          // of finding which limits a step runs into

// The weights of all markers of the set, 1 on average.
Eigen::VectorXd SetWeights(const std::vector<double>& given, int markers) {
  if (given.empty()) return Eigen::VectorXd::Ones(markers);
  assert(static_cast<int>(given.size()) == markers);
  const Eigen::VectorXd weights = Eigen::Map<const Eigen::VectorXd>(given.data(), markers);
  return weights / weights.mean();
}

}  // namespace

PoseSolver::PoseSolver(const MarkerKinematics& kinematics, const IkOptions& options)
    : kinematics_(&kinematics),
      limits_(options.respect_limits ? LimitsOf(*kinematics.skeleton())
                                     : NoLimits(*kinematics.skeleton())),
      set_weights_(SetWeights(options.marker_weights, kinematics.marker_count())),
      weights_(Eigen::VectorXd::Zero(kinematics.marker_count())),
      targets_m_(Eigen::Matrix3Xd::Zero(3, kinematics.marker_count())),
      pose_(kinematics.NewPose()),
      candidate_(kinematics.NewPose()),
      way_back_(Eigen::VectorXd::Zero(kinematics.dof_count())),
      candidate_way_back_(Eigen::VectorXd::Zero(kinematics.dof_count())),
      inverse_(kinematics.dof_count()),
      step_(Eigen::VectorXd::Zero(kinematics.dof_count())) {
  Stand(pose_.angles);
}

void PoseSolver::Aim(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m) {
  for (int m = 0; m < kinematics_->marker_count(); ++m) {
    const auto marker = markers_m.segment<3>(3 * m);
    const bool present = marker.allFinite();
    weights_[m] = present ? set_weights_[m] : 0;
    if (present) targets_m_.col(m) = marker.transpose().cast<double>();
  }
}

void PoseSolver::Stand(const Eigen::RowVectorXd& angles) {
  candidate_.angles = angles.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  pose_.angles = candidate_.angles;
  kinematics_->Place(pose_);
}

void PoseSolver::RunOn(const Eigen::RowVectorXd& angles) { kinematics_->RunOn(angles, pose_); }

double PoseSolver::SumOfSquares(const IkStage& stage, const MarkerPose& pose,
                                const Eigen::VectorXd& way, double pull) const {
  double sum = pull * way.squaredNorm();
  for (int m = 0; m < kinematics_->marker_count(); ++m) {
    const double weight = stage.share[m] * weights_[m];
    if (weight > 0) sum += weight * (targets_m_.col(m) - pose.markers_m.col(m)).squaredNorm();
  }
  return sum;
}

// The linear model about the pose.
void PoseSolver::Linearise(const IkStage& stage, double pull) {
  kinematics_->Differentiate(pose_);
  inverse_.Clear();
  for (int m = 0; m < kinematics_->marker_count(); ++m) {
    const double weight = stage.share[m] * weights_[m];
    if (!(weight > 0)) continue;
    const auto coordinates = kinematics_->Coordinates(m);
    inverse_.Add(coordinates,
                 pose_.jacobian.middleCols(kinematics_->first_column(m),
                                           static_cast<Eigen::Index>(coordinates.size())),
                 targets_m_.col(m) - pose_.markers_m.col(m), weight);
  }
  if (pull > 0) inverse_.AddPull(way_back_, pull);
}

// What the stage does not move is held, and what stands at a limit and is pushed beyond.
void PoseSolver::Hold(const IkStage& stage) {
  const Eigen::VectorXd& push = inverse_.gradient();
  inverse_.Release();
  for (int c = 0; c < kinematics_->dof_count(); ++c) {
    const bool at_limit = (pose_.angles[c] <= limits_.lower[c] && push[c] < 0) ||
                          (pose_.angles[c] >= limits_.upper[c] && push[c] > 0);
    if (at_limit || !stage.moves[c]) inverse_.Hold(c, 0);
  }
}

// The model's best step with what it would carry beyond a limit held at that limit.
void PoseSolver::StepWithinLimits(const IkStage& stage, double damping) {
  Hold(stage);
  bool held_more = true;
  for (int round = 0; held_more && round < kLimitRounds; ++round) {
    step_ = inverse_.Solve(damping);
    held_more = false;
    for (int c = 0; c < kinematics_->dof_count(); ++c) {
      const double angle = pose_.angles[c] + step_[c];
      if (inverse_.IsHeld(c) || (angle >= limits_.lower[c] && angle <= limits_.upper[c])) continue;
      inverse_.Hold(c, std::clamp(angle, limits_.lower[c], limits_.upper[c]) - pose_.angles[c]);
      held_more = true;
    }
  }
  double largest = 0;
  for (int c = 0; c < kinematics_->dof_count(); ++c) {
    if (kinematics_->IsRotation(c)) largest = std::max(largest, std::abs(step_[c]));
  }
  if (largest > kLargestTurn) step_ *= kLargestTurn / largest;
}

void PoseSolver::TakeStep() {
  kinematics_->Advance(pose_, step_, candidate_);
  candidate_.angles = candidate_.angles.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  kinematics_->Place(candidate_);
  candidate_way_back_ = way_back_ - step_;
}

double PoseSolver::Descend(const IkStage& stage, int max_iterations, double pull) {
  way_back_.setZero();
  double damping = 0;
  double sum = SumOfSquares(stage, pose_, way_back_, pull);
  const double precise = kPrecise * kinematics_->marker_count();
  for (int i = 0; i < max_iterations && sum > precise; ++i) {
    Linearise(stage, pull);
    for (bool better = false; !better;) {
      StepWithinLimits(stage, damping);
      const double expected_gain = inverse_.gradient().dot(step_);
      if (expected_gain < kEnoughGain * sum + precise || damping > kLargestDamping) return sum;
      TakeStep();
      const double after = SumOfSquares(stage, candidate_, candidate_way_back_, pull);
      better = after < sum;
      if (better) {
        std::swap(pose_, candidate_);
        std::swap(way_back_, candidate_way_back_);
        sum = after;
        damping = damping > kFirstDamping ? 0.1 * damping : 0;
      } else {
        damping = std::max(kFirstDamping, 10 * damping);
      }
    }
  }
  return sum;
}

IkError PoseSolver::Error() const {
  IkError error;
  double sum = 0;
  int present = 0;
  for (int m = 0; m < kinematics_->marker_count(); ++m) {
    if (!(weights_[m] > 0)) continue;
    const double squared = (targets_m_.col(m) - pose_.markers_m.col(m)).squaredNorm();
    sum += squared;
    error.largest_m = std::max(error.largest_m, std::sqrt(squared));
    ++present;
  }
  if (present > 0) error.rms_m = std::sqrt(sum / present);
  return error;
}

}  // namespace motiondb::core
