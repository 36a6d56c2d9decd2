#include "core/kinematics/pose_solver.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>
#include <set>
#include <utility>

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
  // Regularise rotations that the points leave open towards zero.
  covariance.diagonal().array() += 1e-6 * covariance.norm();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  fit.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  fit.translation() = to_centre - fit.linear() * from_centre;
  return fit;
}

namespace {

constexpr double kMaxRotation = 0.5;    // rad in one step, so that the linear model is valid
constexpr double kMinGain = 1e-6;       // fraction of the sum of squares; a descent ends below it
constexpr double kPrecise = 1e-12;      // m^2 for each marker, the limit of single precision
constexpr double kFirstDamping = 1e-4;  // m^2, after a failed step
constexpr double kMaxDamping = 1e4;     // above it, no step helps
constexpr int kLimitRounds = 8;         // rounds to find the limits that a step exceeds

// Returns the weights of all markers of the set, with mean 1.
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
      to_start_(Eigen::VectorXd::Zero(kinematics.dof_count())),
      candidate_to_start_(Eigen::VectorXd::Zero(kinematics.dof_count())),
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

void PoseSolver::UnwrapAngles(const Eigen::RowVectorXd& angles) {
  kinematics_->UnwrapAngles(angles, pose_);
}

double PoseSolver::SumOfSquares(const IkStage& stage, const MarkerPose& pose,
                                const Eigen::VectorXd& to_start, double pull) const {
  double sum = pull * to_start.squaredNorm();
  for (int m = 0; m < kinematics_->marker_count(); ++m) {
    const double weight = stage.share[m] * weights_[m];
    if (weight > 0) sum += weight * (targets_m_.col(m) - pose.markers_m.col(m)).squaredNorm();
  }
  return sum;
}

// Builds the linear model at the pose.
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
  if (pull > 0) inverse_.AddPull(to_start_, pull);
}

// Holds coordinates that the stage does not move, and those at a limit that are pushed beyond it.
void PoseSolver::Hold(const IkStage& stage) {
  const Eigen::VectorXd& push = inverse_.gradient();
  inverse_.Release();
  for (int c = 0; c < kinematics_->dof_count(); ++c) {
    const bool at_limit = (pose_.angles[c] <= limits_.lower[c] && push[c] < 0) ||
                          (pose_.angles[c] >= limits_.upper[c] && push[c] > 0);
    if (at_limit || !stage.moves[c]) inverse_.Hold(c, 0);
  }
}

// Computes the model's best step; coordinates that would exceed a limit are held at the limit.
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
  if (largest > kMaxRotation) step_ *= kMaxRotation / largest;
}

void PoseSolver::TakeStep() {
  kinematics_->Advance(pose_, step_, candidate_);
  candidate_.angles = candidate_.angles.cwiseMax(limits_.lower).cwiseMin(limits_.upper);
  kinematics_->Place(candidate_);
  candidate_to_start_ = to_start_ - step_;
}

double PoseSolver::Descend(const IkStage& stage, int max_iterations, double pull) {
  to_start_.setZero();
  double damping = 0;
  double sum = SumOfSquares(stage, pose_, to_start_, pull);
  const double precise = kPrecise * kinematics_->marker_count();
  for (int i = 0; i < max_iterations && sum > precise; ++i) {
    Linearise(stage, pull);
    for (bool better = false; !better;) {
      StepWithinLimits(stage, damping);
      const double expected_gain = inverse_.gradient().dot(step_);
      if (expected_gain < kMinGain * sum + precise || damping > kMaxDamping) return sum;
      TakeStep();
      const double after = SumOfSquares(stage, candidate_, candidate_to_start_, pull);
      better = after < sum;
      if (better) {
        std::swap(pose_, candidate_);
        std::swap(to_start_, candidate_to_start_);
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

namespace {

constexpr int kStageIterations = 20;
constexpr double kStagePull = 1e-2;
constexpr int kWholeIterations = 100;
constexpr double kFits = 1e-3;       // m: the search ends if every marker fits
constexpr double kFollows = 0.002;   // m: limbs with such errors stay unchanged
constexpr double kLookAhead = 0.05;  // share of markers of later stages
constexpr double kOffLimits = 0.1;   // fraction of the range between limits
constexpr double kFreeReach = 2.0;   // rad or m: range of restarts without limits

// Whether the root has three perpendicular translations and a free rotation.
bool RootIsFree(const MarkerKinematics& kinematics) {
  const Joint& root = kinematics.skeleton()->joints().front();
  if (!kinematics.TurnsFreely(0) || root.dofs.size() != 6) return false;
  Eigen::Matrix3d axes;
  for (int i = 0; i < 3; ++i) axes.col(i) = root.dofs[i].axis;
  return axes.isUnitary(1e-9) &&
         std::all_of(root.dofs.begin(), root.dofs.begin() + 3,
                     [](const Dof& dof) { return std::isinf(dof.lower) && std::isinf(dof.upper); });
}

// Returns, for each coordinate, whether it moves only markers that do not fit: restarting it may
// help them and harms no others.
std::vector<bool> MisfitCoordinates(const PoseSolver& solver) {
  const MarkerKinematics& kinematics = solver.kinematics();
  std::vector<bool> off(static_cast<std::size_t>(kinematics.dof_count()), false);
  std::vector<bool> well = off;
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    if (!(solver.weight(m) > 0)) continue;
    const bool near = (solver.target(m) - solver.pose().markers_m.col(m)).norm() < kFollows;
    for (const int c : kinematics.Coordinates(m)) (near ? well : off)[c] = true;
  }
  for (std::size_t c = 0; c < off.size(); ++c) off[c] = off[c] && !well[c];
  return off;
}

}  // namespace

PoseSearch::PoseSearch(const MarkerKinematics& kinematics)
    : observable_(static_cast<std::size_t>(kinematics.dof_count()), false),
      root_is_free_(RootIsFree(kinematics)) {
  AddStages(kinematics);
}

// Each stage adds the markers with the next larger number of coordinates, and frees these
// coordinates.
void PoseSearch::AddStages(const MarkerKinematics& kinematics) {
  std::set<std::size_t> sizes;
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    sizes.insert(kinematics.Coordinates(m).size());
  }
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    const double beyond = static_cast<double>(kinematics.Coordinates(m).size() - *sizes.begin());
    rigidity_.push_back(std::exp2(-beyond / 2));
  }
  for (const std::size_t size : sizes) {
    IkStage stage{.moves = observable_, .share = {}};
    for (int m = 0; m < kinematics.marker_count(); ++m) {
      const bool included = kinematics.Coordinates(m).size() <= size;
      stage.share.push_back(included ? 1 : kLookAhead);
      if (!included) continue;
      for (const int c : kinematics.Coordinates(m)) stage.moves[c] = observable_[c] = true;
    }
    stages_.push_back(std::move(stage));
  }
}

Eigen::RowVectorXd PoseSearch::NeutralAngles(const PoseSolver& solver) const {
  Eigen::RowVectorXd angles = Eigen::RowVectorXd::Zero(solver.kinematics().dof_count());
  for (Eigen::Index c = 0; c < angles.size(); ++c) {
    const double lower = solver.limits().lower[c];
    const double upper = solver.limits().upper[c];
    const double range = upper - lower;
    const double margin = observable_[c] && std::isfinite(range) ? kOffLimits * range : 0;
    angles[c] = std::clamp(0.0, lower + margin, upper - margin);
  }
  return angles;
}

void PoseSearch::FitRoot(PoseSolver& solver) const {
  if (!root_is_free_) return;
  const MarkerKinematics& kinematics = solver.kinematics();
  Eigen::VectorXd weights(kinematics.marker_count());
  Eigen::Matrix3Xd targets(3, kinematics.marker_count());
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    weights[m] = rigidity_[m] * solver.weight(m);
    targets.col(m) = solver.target(m);
  }
  const Eigen::Isometry3d rigid_fit = FitRigid(solver.pose().markers_m, targets, weights);
  const Eigen::AngleAxisd turn(rigid_fit.linear());
  const Eigen::Vector3d origin = solver.pose().world_from_joint[0].translation();
  const Joint& root = kinematics.skeleton()->joints().front();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(kinematics.dof_count());
  for (int i = 0; i < 3; ++i) step[i] = root.dofs[i].axis.dot(rigid_fit * origin - origin);
  step.segment<3>(3) = turn.angle() * turn.axis();
  MarkerPose moved = solver.pose();
  kinematics.Advance(solver.pose(), step, moved);
  solver.Stand(moved.angles);
}

double PoseSearch::DescendDownTheTree(PoseSolver& solver) const {
  for (const IkStage& stage : stages_) solver.Descend(stage, kStageIterations, kStagePull);
  return solver.Descend(whole(), kWholeIterations, 0);
}

double PoseSearch::Run(int attempts, PoseSolver& solver) const {
  const Eigen::RowVectorXd neutral = NeutralAngles(solver);
  solver.Stand(neutral);
  FitRoot(solver);
  double min_sum = DescendDownTheTree(solver);
  Eigen::RowVectorXd best = solver.pose().angles;
  std::mt19937 random(1);  // deterministic starts
  const auto number = [&random] { return static_cast<double>(random()) / std::mt19937::max(); };
  for (int attempt = 1; attempt < attempts && solver.Error().largest_m > kFits; ++attempt) {
    solver.Stand(best);
    std::vector<bool> misfit = MisfitCoordinates(solver);
    if (std::none_of(misfit.begin(), misfit.end(), [](bool is) { return is; }))
      misfit = observable_;
    Eigen::RowVectorXd angles = best;
    for (Eigen::Index c = 0; c < angles.size(); ++c) {
      if (!misfit[c]) continue;
      const double lower = std::max(solver.limits().lower[c], neutral[c] - kFreeReach);
      const double upper = std::min(solver.limits().upper[c], neutral[c] + kFreeReach);
      angles[c] = lower + number() * (upper - lower);
    }
    solver.Stand(angles);
    if (misfit[0]) FitRoot(solver);
    const double sum = DescendDownTheTree(solver);
    if (sum < min_sum) {
      min_sum = sum;
      best = solver.pose().angles;
    }
  }
  solver.Stand(best);
  return min_sum;
}

}  // namespace motiondb::core
