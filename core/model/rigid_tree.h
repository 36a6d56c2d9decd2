// Pairs of markers with constant distance (on one bone), to restore the bone lengths of a predicted
// pose. Immutable.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace motiondb::core {

struct ModelParts;

struct RigidTree {
  struct Bone {
    int marker = 0;
    int parent = -1;  // an earlier marker at constant distance; -1: none
  };
  std::vector<Bone> bones;  // one for each marker, from the hips outward

  // Returns the positions (3 N_v) with the given bone directions and the bone lengths of
  // `reference` (3 N_v).
  Eigen::RowVectorXf Restore(const Eigen::RowVectorXf& positions,
                             const Eigen::RowVectorXf& reference) const;
};

// Returns the minimum spanning tree by the variance of distances within the stored clips. Pairs
// with a standard deviation above 0.01 leg lengths are not connected.
RigidTree FindRigidTree(const ModelParts& parts);

}  // namespace motiondb::core
