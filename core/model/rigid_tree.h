// Which markers keep their distance: pairs on one bone. A predicted pose is brought back to the
// body's own lengths along them. Immutable; safe to share.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace motiondb::core {

struct ModelParts;

struct RigidTree {
  struct Bone {
    int marker = 0;
    int parent = -1;  // comes earlier; -1 where the marker keeps no distance to any before it
  };
  std::vector<Bone> bones;  // every marker once, from the hips outward

  // Positions (3 N_v) with each bone in its direction as given and as long as in `reference`
  // (3 N_v).
  Eigen::RowVectorXf Restore(const Eigen::RowVectorXf& positions,
                             const Eigen::RowVectorXf& reference) const;
};

// The tree of pairs whose distance varies least within the stored clips, as far as it hardly does.
RigidTree FindRigidTree(const ModelParts& parts);

}  // namespace motiondb::core
