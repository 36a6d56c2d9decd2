// How the distances of pairs of markers vary, trees of the markers by that, and bones of constant
// length, which restore the bone lengths of a predicted pose.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

struct ModelParts;

// Mean and variance of the distance of each pair of markers. Lengths are in leg lengths.
class DistanceSpread {
 public:
  explicit DistanceSpread(int marker_count);

  // Adds frames of one motion (frames x 6 N_v, unscaled states). Variances are those within
  // motions. O(frames * markers^2).
  void Add(const Eigen::Ref<const FrameMatrix>& states);

  // N_v x N_v, symmetric; zero on the diagonal. REQUIRES: frames were added.
  Eigen::MatrixXd Means() const;
  Eigen::MatrixXd Variances() const;

 private:
  Eigen::MatrixXd sums_;     // lower triangles
  Eigen::MatrixXd squares_;  // of the differences from the mean of their motion
  Eigen::Index frames_ = 0;
};

// Returns the spread in a sample of the clips: 16 evenly spread frames of each of up to 64 clips.
DistanceSpread SpreadOfClips(const ModelParts& parts);

// A link of a tree.
struct TreeLink {
  int node = 0;
  int parent = -1;  // an earlier node; -1: the first
};

// Returns the minimum spanning tree of a complete graph with these edge costs (symmetric, finite),
// by Prim's algorithm: nodes in the order in which they are joined, from `first` outward. Ties: the
// lower index. O(nodes^2).
std::vector<TreeLink> SpanningTree(const Eigen::MatrixXd& costs, int first);

// Pairs of markers with constant distance (on one bone). Immutable.
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
