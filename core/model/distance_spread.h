// How the distances of pairs of markers vary, and spanning trees of the markers.
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

}  // namespace motiondb::core
