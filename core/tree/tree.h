// The binary tree (section III-B): all frames, split again and again into two groups of alike
// states. Immutable once made; safe to share between threads.
//
// Frames are kept in one order in which every node is a contiguous range, so a node is two numbers
// and its copies in lower layers cost nothing. Within a layer nodes are numbered from 0, left to
// right; a `node` here is always such a number and goes with a layer, a `branch` is an index into
// branches().
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

// One row for each branch that is divided, in order of branch. Empty where they are not known, as
// in trees of older stores.
struct SplitPlanes {
  FrameMatrix axes;  // divided branches x dimensions, of unit length
  // States whose inner product with the axis is at most this go left.
  std::vector<double> thresholds;

  bool empty() const { return thresholds.empty(); }
};

// Whether a state (1 x dimensions) goes left at a threshold on an axis.
inline bool IsLeft(const Eigen::Ref<const Eigen::RowVectorXf>& axis, double threshold,
                   const Eigen::Ref<const Eigen::RowVectorXf>& state) {
  return axis.cast<double>().dot(state.cast<double>()) <= threshold;
}

// A group of frames and how it was split. Branch 0 is the root; children follow their parent.
struct Branch {
  std::int32_t parent = -1;
  std::int32_t left = -1;   // -1 in a leaf
  std::int32_t right = -1;  // left + 1, or -1 in a leaf
  std::int32_t begin = 0;   // its frames: frame_order()[begin .. end)
  std::int32_t end = 0;
  std::int32_t layer = 1;  // the first layer it is in
};

class Tree {
 public:
  Tree() = default;
  // DATA_LOSS if the branches are not a tree over a permutation of the frames, or the planes, if
  // there are any, not one for each that is divided (loading is parsing).
  static absl::StatusOr<Tree> Create(std::vector<std::int32_t> frame_order,
                                     std::vector<Branch> branches, SplitPlanes planes = {});

  int frame_count() const { return static_cast<int>(frame_order_.size()); }
  int layer_count() const { return static_cast<int>(layers_.size()); }
  // Nodes of a layer, 1 <= layer <= layer_count().
  int node_count(int layer) const { return static_cast<int>(at(layer).branch.size()); }
  // Nodes of all layers together.
  int total_node_count() const;

  const std::vector<std::int32_t>& frame_order() const { return frame_order_; }
  const std::vector<Branch>& branches() const { return branches_; }
  const SplitPlanes& planes() const { return planes_; }
  // Whether LeafOf knows the way: a tree of one node always does.
  bool has_planes() const { return branches_.size() == 1 || !planes_.empty(); }
  // The leaf (a branch) that a scaled state (dimensions) comes to. REQUIRES: has_planes(). The
  // frames that the tree was built from come to their own leaf, but for some that project onto the
  // threshold itself within single precision. O(depth * dimensions).
  int LeafOf(const float* state) const;

  // Branch that a layer's node stands for. A leaf's copies stand for the same branch.
  int branch(int layer, int node) const { return at(layer).branch[node]; }
  // Node of the layer above; -1 for the root.
  int parent(int layer, int node) const { return at(layer).parent[node]; }
  // First of its children in the layer below; it has child_count of them, 1 (a copy) or 2.
  int first_child(int layer, int node) const { return at(layer).first_child[node]; }
  int child_count(int layer, int node) const {
    return at(layer).first_child[node + 1] - at(layer).first_child[node];
  }
  // Node of a layer that holds a frame. O(1).
  int node_of_frame(int layer, int frame) const {
    return at(layer).node_of_bottom[bottom_of_frame_[frame]];
  }

 private:
  struct Layer {
    std::vector<std::int32_t> branch;
    std::vector<std::int32_t> parent;
    std::vector<std::int32_t> first_child;     // one more than nodes; empty in the bottom layer
    std::vector<std::int32_t> node_of_bottom;  // node of this layer above each bottom node
  };
  const Layer& at(int layer) const { return layers_[static_cast<std::size_t>(layer) - 1]; }
  absl::Status Check() const;
  absl::Status CheckPlanes() const;
  void MakeLayers();

  std::vector<std::int32_t> frame_order_;
  std::vector<Branch> branches_;
  SplitPlanes planes_;
  std::vector<std::int32_t> plane_of_branch_;  // -1 in a leaf
  std::vector<Layer> layers_;
  std::vector<std::int32_t> bottom_of_frame_;
};

}  // namespace motiondb::core
