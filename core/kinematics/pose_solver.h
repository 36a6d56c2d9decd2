// A single pose for markers: from the pose before, or searched for without one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/singularity_robust.h"

namespace motiondb::core {

// What a caller of inverse kinematics chooses. Plain values.
struct IkOptions {
  // Every angle stays within its joint's limits.
  bool respect_limits = true;
  // How much each marker's squared distance counts, not negative; empty: all alike. Only their
  // ratios matter. A body of other proportions than the markers' wants feet and pelvis to weigh
  // more than what lies between.
  std::vector<double> marker_weights = {};
  // Pull of each coordinate towards the frame before, in m^2: 1e-4 for one radian weighs as much as
  // a marker 1 cm off. Angles that the markers hardly tell, such as the twist of a straight arm,
  // then stay calm; those they tell well are not held back to speak of. It grows where the markers
  // cannot be met: twofold at 5 mm rms, a hundredfold at 5 cm. 0: none.
  double smoothness = 1e-4;
};

// How far a pose's markers are from where they should be (m), over the markers that are present,
// each counted alike.
struct IkError {
  double rms_m = 0;
  double largest_m = 0;
};

// The rigid motion that brings points nearest to others. Safe to call from any thread.

// The isometry that minimises the weighted sum of squared distances from each moved column of
// `from` to that of `to` (Kabsch; weights not negative). Where points on a line or a single one
// leave a turn open, it turns as little as it can. Columns of weight 0 may hold anything finite.
Eigen::Isometry3d FitRigid(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to,
                           const Eigen::VectorXd& weights);

// One pose brought to its markers: Levenberg-Marquardt with the SR inverse, within joint limits.
// Thread-compatible: one solver a thread. It borrows the MarkerKinematics, which must outlive it.

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

// A pose for markers without a pose before: down the tree, from several starts.
// Immutable after construction and safe to share between threads. It borrows nothing.
class PoseSearch {
 public:
  explicit PoseSearch(const MarkerKinematics& kinematics);

  // The last stage: the whole body, all markers.
  const IkStage& whole() const { return stages_.back(); }

  // Leaves solver.pose() at the best of up to `attempts` descents to the solver's targets, and
  // returns its sum of squares (m^2). The first begins near zero, the others elsewhere in those
  // limbs whose markers are still off; a fit within a millimetre ends the search. Deterministic.
  // REQUIRES: the solver is on the same kinematics.
  double Run(int attempts, PoseSolver& solver) const;

 private:
  void AddStages(const MarkerKinematics& kinematics);
  // Angles to begin at: near zero, but off the limits, where a straight limb can bend either way.
  Eigen::RowVectorXd NeutralAngles(const PoseSolver& solver) const;
  // Lays a root that moves and turns freely so that the markers fit as those of a rigid body.
  void LayRoot(PoseSolver& solver) const;
  double DescendDownTheTree(PoseSolver& solver) const;

  std::vector<IkStage> stages_;
  std::vector<bool> told_;  // coordinates that move a marker
  // How much of a rigid body each marker is: most where the fewest coordinates move it.
  std::vector<double> rigidity_;
  bool root_is_free_ = false;
};

}  // namespace motiondb::core
