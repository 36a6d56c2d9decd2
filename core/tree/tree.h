// The binary tree (section III-B): recursive splits of all frames into two groups of similar
// states. Immutable after Create.
//
// Frames have one order in which every node is a contiguous range, so a node is two numbers and its
// copies in lower layers cost nothing. Nodes of a layer are numbered from 0, left to right. `node`:
// such a number, valid together with its layer; `branch`: an index into branches().
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

// One row for each split branch, in order of branch. Empty if unknown, as in trees of older stores.
struct SplitPlanes {
  FrameMatrix axes;  // split branches x dimensions, unit length
  // States with an inner product of at most this with the axis go left.
  std::vector<double> thresholds;

  bool empty() const { return thresholds.empty(); }
};

// Whether a state (1 x dimensions) goes left at a split.
inline bool IsLeft(const Eigen::Ref<const Eigen::RowVectorXf>& axis, double threshold,
                   const Eigen::Ref<const Eigen::RowVectorXf>& state) {
  return axis.cast<double>().dot(state.cast<double>()) <= threshold;
}

// A group of frames and how it was split. Branch 0 is the root; children follow their parent.
struct Branch {
  std::int32_t parent = -1;
  std::int32_t left = -1;   // -1: leaf
  std::int32_t right = -1;  // left + 1, or -1: leaf
  std::int32_t begin = 0;   // its frames: frame_order()[begin .. end)
  std::int32_t end = 0;
  std::int32_t layer = 1;  // its first layer
};

class Tree {
 public:
  Tree() = default;
  // DATA_LOSS if the branches are not a tree over a permutation of the frames, or if there are
  // planes but not one for each split branch. Validates, because the input may be loaded from
  // storage.
  static absl::StatusOr<Tree> Create(std::vector<std::int32_t> frame_order,
                                     std::vector<Branch> branches, SplitPlanes planes = {});

  int frame_count() const { return static_cast<int>(frame_order_.size()); }
  int layer_count() const { return static_cast<int>(layers_.size()); }
  // Number of nodes of a layer, 1 <= layer <= layer_count().
  int node_count(int layer) const { return static_cast<int>(at(layer).branch.size()); }
  // Number of nodes of all layers.
  int total_node_count() const;

  const std::vector<std::int32_t>& frame_order() const { return frame_order_; }
  const std::vector<Branch>& branches() const { return branches_; }
  const SplitPlanes& planes() const { return planes_; }
  // Whether LeafOf is available; always true for a tree of one node.
  bool has_planes() const { return branches_.size() == 1 || !planes_.empty(); }
  // Returns the leaf (a branch) of a scaled state (dimensions). Frames of the build return to their
  // own leaf, except some on a threshold itself within single precision. O(depth * dimensions).
  // REQUIRES: has_planes().
  int LeafOf(const float* state) const;

  // Branch of a layer's node. Copies of a leaf have the same branch.
  int branch(int layer, int node) const { return at(layer).branch[node]; }
  // Parent in the layer above; -1 for the root.
  int parent(int layer, int node) const { return at(layer).parent[node]; }
  // First child in the layer below. There are child_count children: 1 (a copy) or 2.
  int first_child(int layer, int node) const { return at(layer).first_child[node]; }
  int child_count(int layer, int node) const {
    return at(layer).first_child[node + 1] - at(layer).first_child[node];
  }
  // Node of a layer that contains a frame. O(1).
  int node_of_frame(int layer, int frame) const {
    return at(layer).node_of_bottom[bottom_of_frame_[frame]];
  }

 private:
  struct Layer {
    std::vector<std::int32_t> branch;
    std::vector<std::int32_t> parent;
    std::vector<std::int32_t> first_child;  // one more entry than nodes; empty in the bottom layer
    std::vector<std::int32_t> node_of_bottom;  // ancestor in this layer of each bottom node
  };
  const Layer& at(int layer) const { return layers_[static_cast<std::size_t>(layer) - 1]; }
  absl::Status Check() const;
  absl::Status CheckPlanes() const;
  void MakeLayers();

  std::vector<std::int32_t> frame_order_;
  std::vector<Branch> branches_;
  SplitPlanes planes_;
  std::vector<std::int32_t> plane_of_branch_;  // -1: leaf
  std::vector<Layer> layers_;
  std::vector<std::int32_t> bottom_of_frame_;
};

}  // namespace motiondb::core
