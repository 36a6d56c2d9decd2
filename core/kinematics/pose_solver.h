// Solves one pose for markers: from the previous pose, or by global search.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/singularity_robust.h"

namespace motiondb::core {

// Options of inverse kinematics.
struct IkOptions {
  // Every angle stays within its joint's limits.
  bool respect_limits = true;
  // Weight of each marker's squared distance, >= 0; empty: equal. Only ratios matter. For a body
  // with other proportions than the markers' subject, feet and pelvis need larger weights than the
  // markers between them.
  std::vector<double> marker_weights = {};
  // Pull of each coordinate towards the previous frame, m^2: with 1e-4, one radian counts as much
  // as a marker error of 1 cm. Keeps angles calm that markers barely determine, such as the twist
  // of a straight arm; hardly affects the others. Grows with the marker error: twofold at 5 mm rms,
  // a hundredfold at 5 cm. 0: none.
  double smoothness = 1e-4;
};

// Distance (m) of a pose's markers from their targets, over the markers present, unweighted.
struct IkError {
  double rms_m = 0;
  double largest_m = 0;
};

// Returns the isometry that minimises the weighted sum of squared distances between the moved
// columns of `from` and the columns of `to` (Kabsch; weights >= 0). If the points leave a rotation
// open (a line, a single point), rotates as little as possible. Columns of weight 0 may have any
// finite values.
Eigen::Isometry3d FitRigid(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to,
                           const Eigen::VectorXd& weights);

// A stage of the solution: which coordinates move, and the share of each marker's weight.
struct IkStage {
  std::vector<bool> moves;    // of each coordinate
  std::vector<double> share;  // of each marker's weight, 0 to 1
};

// Fits one pose to its markers: Levenberg-Marquardt with the SR inverse, within joint limits. The
// MarkerKinematics must outlive the solver. Only the constructor allocates.
class PoseSolver {
 public:
  // Starts at zero angles, or at the limit nearest to zero. REQUIRES: options.marker_weights is
  // empty or has one for each marker, not all of them 0.
  PoseSolver(const MarkerKinematics& kinematics, const IkOptions& options);

  const MarkerKinematics& kinematics() const { return *kinematics_; }
  const JointLimits& limits() const { return limits_; }  // as respected
  const MarkerPose& pose() const { return pose_; }       // placed, within limits

  // Sets the targets of the markers: 1 x 3 * marker_count, m, world; NaN: missing.
  void Aim(const Eigen::Ref<const Eigen::RowVectorXf>& markers_m);
  bool has_targets() const { return weights_.maxCoeff() > 0; }
  // m, world; valid if weight(marker) > 0.
  auto target(int marker) const { return targets_m_.col(marker); }
  // Weight of a marker in the sum of squares; 0 if missing. The mean over the set is 1.
  double weight(int marker) const { return weights_[marker]; }

  // Sets the pose's angles (1 x dof_count), clamped to the limits.
  void Stand(const Eigen::RowVectorXd& angles);
  // Unwraps the pose's angles relative to `angles`.
  void UnwrapAngles(const Eigen::RowVectorXd& angles);
  // Minimises the weighted sum of squared distances to the targets, plus `pull` (m^2) times the
  // squared displacement of the coordinates from the start. Ends when a step gains almost nothing.
  // Returns the final sum (m^2). Deterministic.
  double Descend(const IkStage& stage, int max_iterations, double pull);

  IkError Error() const;

 private:
  double SumOfSquares(const IkStage& stage, const MarkerPose& pose, const Eigen::VectorXd& to_start,
                      double pull) const;
  void Linearise(const IkStage& stage, double pull);
  void Hold(const IkStage& stage);
  void StepWithinLimits(const IkStage& stage, double damping);
  void TakeStep();

  const MarkerKinematics* kinematics_;
  JointLimits limits_;
  Eigen::VectorXd set_weights_;  // of all markers, if present
  Eigen::VectorXd weights_;      // of this frame
  Eigen::Matrix3Xd targets_m_;
  MarkerPose pose_;
  MarkerPose candidate_;
  Eigen::VectorXd to_start_;            // of each coordinate, back to the start
  Eigen::VectorXd candidate_to_start_;  // of the candidate
  SingularityRobustInverse inverse_;
  Eigen::VectorXd step_;
};

// Global search for a pose: descents in stages from the root outwards, from several starts.
// Immutable after construction.
class PoseSearch {
 public:
  explicit PoseSearch(const MarkerKinematics& kinematics);

  // The last stage: whole body, all markers.
  const IkStage& whole() const { return stages_.back(); }

  // Sets solver.pose() to the best of up to `attempts` descents to the solver's targets, and
  // returns its sum of squares (m^2). The first starts near zero; the others randomise limbs whose
  // markers do not fit. Ends at a fit within a millimetre. Deterministic. REQUIRES: the solver uses
  // the same kinematics.
  double Run(int attempts, PoseSolver& solver) const;

 private:
  void AddStages(const MarkerKinematics& kinematics);
  // Returns start angles: near zero, but away from limits, where a straight limb can bend only one
  // way.
  Eigen::RowVectorXd NeutralAngles(const PoseSolver& solver) const;
  // Moves a free root so that the markers fit as a rigid body.
  void FitRoot(PoseSolver& solver) const;
  double DescendDownTheTree(PoseSolver& solver) const;

  std::vector<IkStage> stages_;
  std::vector<bool> observable_;  // coordinates that move a marker
  // Rigidity of each marker relative to the root: highest if the fewest coordinates move it.
  std::vector<double> rigidity_;
  bool root_is_free_ = false;
};

}  // namespace motiondb::core
