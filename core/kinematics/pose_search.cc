#include "core/kinematics/pose_search.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "core/kinematics/rigid_fit.h"

namespace motiondb::core {
namespace {

constexpr int kStageIterations = 20;
constexpr double kStagePull = 1e-2;
constexpr int kWholeIterations = 100;
constexpr double kFits = 1e-3;       // m, of every marker: the search ends
constexpr double kFollows = 0.002;   // m: a limb whose markers are this near is left as it is
constexpr double kLookAhead = 0.05;  // share of a marker that a stage cannot bring home yet
constexpr double kOffLimits = 0.1;   // of the range between two limits
constexpr double kFreeReach = 2.0;   // rad or m that a restart moves what has no limits

// Three translations at right angles and a free rotation.
bool RootIsFree(const MarkerKinematics& kinematics) {
  const Joint& root = kinematics.skeleton()->joints().front();
  if (!kinematics.TurnsFreely(0) || root.dofs.size() != 6) return false;
  Eigen::Matrix3d axes;
  for (int i = 0; i < 3; ++i) axes.col(i) = root.dofs[i].axis;
  return axes.isUnitary(1e-9) &&
         std::all_of(root.dofs.begin(), root.dofs.begin() + 3,
                     [](const Dof& dof) { return std::isinf(dof.lower) && std::isinf(dof.upper); });
}

// Of each coordinate: moves only markers that are still off, so that another start may help them
// and harms none.
std::vector<bool> Astray(const PoseSolver& solver) {
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
    : told_(static_cast<std::size_t>(kinematics.dof_count()), false),
      root_is_free_(RootIsFree(kinematics)) {
  AddStages(kinematics);
}

// A stage adds the markers that the next larger number of coordinates moves, and frees these.
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
    IkStage stage{.moves = told_, .share = {}};
    for (int m = 0; m < kinematics.marker_count(); ++m) {
      const bool home = kinematics.Coordinates(m).size() <= size;
      stage.share.push_back(home ? 1 : kLookAhead);
      if (!home) continue;
      for (const int c : kinematics.Coordinates(m)) stage.moves[c] = told_[c] = true;
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
    const double margin = told_[c] && std::isfinite(range) ? kOffLimits * range : 0;
    angles[c] = std::clamp(0.0, lower + margin, upper - margin);
  }
  return angles;
}

void PoseSearch::LayRoot(PoseSolver& solver) const {
  if (!root_is_free_) return;
  const MarkerKinematics& kinematics = solver.kinematics();
  Eigen::VectorXd weights(kinematics.marker_count());
  Eigen::Matrix3Xd targets(3, kinematics.marker_count());
  for (int m = 0; m < kinematics.marker_count(); ++m) {
    weights[m] = rigidity_[m] * solver.weight(m);
    targets.col(m) = solver.target(m);
  }
  const Eigen::Isometry3d laid = FitRigid(solver.pose().markers_m, targets, weights);
  const Eigen::AngleAxisd turn(laid.linear());
  const Eigen::Vector3d origin = solver.pose().world_from_joint[0].translation();
  const Joint& root = kinematics.skeleton()->joints().front();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(kinematics.dof_count());
  for (int i = 0; i < 3; ++i) step[i] = root.dofs[i].axis.dot(laid * origin - origin);
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
  LayRoot(solver);
  double least = DescendDownTheTree(solver);
  Eigen::RowVectorXd best = solver.pose().angles;
  std::mt19937 random(1);  // the same starts every time
  const auto number = [&random] { return static_cast<double>(random()) / std::mt19937::max(); };
  for (int attempt = 1; attempt < attempts && solver.Error().largest_m > kFits; ++attempt) {
    solver.Stand(best);
    std::vector<bool> astray = Astray(solver);
    if (std::none_of(astray.begin(), astray.end(), [](bool is) { return is; })) astray = told_;
    Eigen::RowVectorXd angles = best;
    for (Eigen::Index c = 0; c < angles.size(); ++c) {
      if (!astray[c]) continue;
      const double lower = std::max(solver.limits().lower[c], neutral[c] - kFreeReach);
      const double upper = std::min(solver.limits().upper[c], neutral[c] + kFreeReach);
      angles[c] = lower + number() * (upper - lower);
    }
    solver.Stand(angles);
    if (astray[0]) LayRoot(solver);
    const double sum = DescendDownTheTree(solver);
    if (sum < least) {
      least = sum;
      best = solver.pose().angles;
    }
  }
  solver.Stand(best);
  return least;
}

}  // namespace motiondb::core
