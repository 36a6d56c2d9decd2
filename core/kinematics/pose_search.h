// A pose for markers without a pose before: down the tree, from several starts.
// Immutable after construction and safe to share between threads. It borrows nothing.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/kinematics/pose_solver.h"

namespace motiondb::core {

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
