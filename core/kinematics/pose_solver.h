// One pose brought to its markers: Levenberg-Marquardt with the SR inverse, within joint limits.
// Thread-compatible: one solver a thread. It borrows the MarkerKinematics, which must outlive it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/kinematics/ik_options.h"
#include "core/kinematics/joint_limits.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/singularity_robust.h"

namespace motiondb::core {

// The part of the body that a descent moves, and how much it looks at each marker.
struct IkStage {
  std::vector<bool> moves;    // of each coordinate
  std::vector<double> share;  // of each marker's weight, 0 to 1
};

// Nothing below takes memory, but for the constructor.
class PoseSolver {
 public:
  // The pose begins with all angles zero, or the limit next to zero.
  // REQUIRES: options.marker_weights is empty or has one for each marker, not all of them zero.
  PoseSolver(const MarkerKinematics& kinematics, const IkOptions& options);

  const MarkerKinematics& kinematics() const { return *kinematics_; }
  const JointLimits& limits() const { return limits_; }  // as respected
  const MarkerPose& pose() const { return pose_; }       // placed, within limits

  // Where the markers should be: 1 x 3 * marker_count, m, world; NaN where one is missing.
  void Aim(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m);
  bool has_targets() const { return weights_.maxCoeff() > 0; }
  // m, world; meaningful where weight(marker) > 0.
  auto target(int marker) const { return targets_m_.col(marker); }
  // Of a marker in the sum of squares; 0 for one that is missing. 1 on average over the set.
  double weight(int marker) const { return weights_[marker]; }

  // Puts the pose at these angles (1 x dof_count), or at the limits next to them.
  void Stand(const Eigen::RowVectorXd& angles);
  // Writes the pose's angles without the whole turns that part them from `angles`.
  void RunOn(const Eigen::RowVectorXd& angles);
  // Moves the pose downhill on the weighted sum of squared distances to the targets, plus `pull`
  // (m^2) times the squared way from where the descent began, until a step gains next to nothing.
  // Deterministic. Returns the sum (m^2) that it ends at.
  double Descend(const IkStage& stage, int max_iterations, double pull);

  IkError Error() const;

 private:
  double SumOfSquares(const IkStage& stage, const MarkerPose& pose, const Eigen::VectorXd& way_back,
                      double pull) const;
  void Linearise(const IkStage& stage, double pull);
  void Hold(const IkStage& stage);
  void StepWithinLimits(const IkStage& stage, double damping);
  void TakeStep();

  const MarkerKinematics* kinematics_;
  JointLimits limits_;
  Eigen::VectorXd set_weights_;  // of all markers, as if present
  Eigen::VectorXd weights_;      // of this frame's
  Eigen::Matrix3Xd targets_m_;
  MarkerPose pose_;
  MarkerPose candidate_;
  Eigen::VectorXd way_back_;            // of each coordinate to where the descent began
  Eigen::VectorXd candidate_way_back_;  // the same of the candidate
  SingularityRobustInverse inverse_;
  Eigen::VectorXd step_;
};

}  // namespace motiondb::core
