#include "core/tree/tree.h"

#include <algorithm>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<Tree> Tree::Create(std::vector<std::int32_t> frame_order,
                                  std::vector<Branch> branches, SplitPlanes planes) {
  Tree tree;
  tree.frame_order_ = std::move(frame_order);
  tree.branches_ = std::move(branches);
  tree.planes_ = std::move(planes);
  MOTIONDB_RETURN_IF_ERROR(tree.Check());
  MOTIONDB_RETURN_IF_ERROR(tree.CheckPlanes());
  std::int32_t split_count = 0;
  for (const Branch& branch : tree.branches_) {
    tree.plane_of_branch_.push_back(branch.left < 0 ? -1 : split_count++);
  }
  tree.MakeLayers();
  return tree;
}

absl::Status Tree::Check() const {
  std::vector<bool> seen(frame_order_.size());
  for (std::int32_t frame : frame_order_) {
    if (frame < 0 || frame >= frame_count() || seen[frame]) {
      return DataLoss("tree: the frame order is not a permutation at frame {}", frame);
    }
    seen[frame] = true;
  }
  const auto count = static_cast<std::int32_t>(branches_.size());
  if (count == 0 || frame_order_.empty() || branches_[0].begin != 0 ||
      branches_[0].end != frame_count() || branches_[0].layer != 1) {
    return DataLoss("tree: the root does not contain all frames");
  }
  std::vector<bool> reached(branches_.size());
  reached[0] = true;
  for (std::int32_t b = 0; b < count; ++b) {
    const Branch& branch = branches_[b];
    if (!reached[b]) return DataLoss("tree: branch {} has no parent before it", b);
    if (branch.left == -1 && branch.right == -1) continue;
    if (branch.left <= b || branch.right != branch.left + 1 || branch.right >= count) {
      return DataLoss("tree: branch {} has no valid children", b);
    }
    const Branch& left = branches_[branch.left];
    const Branch& right = branches_[branch.right];
    if (left.parent != b || right.parent != b || left.layer != branch.layer + 1 ||
        right.layer != branch.layer + 1 || left.begin != branch.begin || left.end != right.begin ||
        right.end != branch.end || left.begin >= left.end || right.begin >= right.end ||
        reached[branch.left]) {
      return DataLoss("tree: the children of branch {} do not partition it", b);
    }
    reached[branch.left] = reached[branch.right] = true;
  }
  return absl::OkStatus();
}

absl::Status Tree::CheckPlanes() const {
  if (planes_.empty() && planes_.axes.size() == 0) return absl::OkStatus();
  const auto split_count =
      std::ranges::count_if(branches_, [](const Branch& b) { return b.left >= 0; });
  const bool finite = planes_.axes.allFinite() &&
                      std::ranges::all_of(planes_.thresholds, [](double t) { return t - t == 0; });
  if (std::ssize(planes_.thresholds) == split_count && planes_.axes.rows() == split_count &&
      finite) {
    return absl::OkStatus();
  }
  return DataLoss("tree: {} thresholds on {} axes for {} split branches", planes_.thresholds.size(),
                  planes_.axes.rows(), split_count);
}

int Tree::LeafOf(const float* state) const {
  const Eigen::Map<const Eigen::RowVectorXf> x(state, planes_.axes.cols());
  int b = 0;
  while (branches_[b].left >= 0) {
    const int plane = plane_of_branch_[b];
    b = IsLeft(planes_.axes.row(plane), planes_.thresholds[plane], x) ? branches_[b].left
                                                                      : branches_[b].right;
  }
  return b;
}

void Tree::MakeLayers() {
  layers_.push_back({.branch = {0}, .parent = {-1}, .first_child = {}, .node_of_bottom = {}});
  for (bool split = true; split;) {
    Layer& above = layers_.back();
    Layer below;
    split = false;
    for (std::int32_t node = 0; node < static_cast<std::int32_t>(above.branch.size()); ++node) {
      const Branch& branch = branches_[above.branch[node]];
      above.first_child.push_back(static_cast<std::int32_t>(below.branch.size()));
      below.parent.push_back(node);
      if (branch.left < 0) {
        below.branch.push_back(above.branch[node]);  // a leaf is carried down as a copy
        continue;
      }
      split = true;
      below.parent.push_back(node);
      below.branch.push_back(branch.left);
      below.branch.push_back(branch.right);
    }
    above.first_child.push_back(static_cast<std::int32_t>(below.branch.size()));
    if (split) {
      layers_.push_back(std::move(below));
    } else {
      above.first_child.clear();
    }
  }

  Layer& bottom = layers_.back();
  bottom_of_frame_.resize(frame_order_.size());
  bottom.node_of_bottom.resize(bottom.branch.size());
  for (std::int32_t node = 0; node < static_cast<std::int32_t>(bottom.branch.size()); ++node) {
    bottom.node_of_bottom[node] = node;
    const Branch& branch = branches_[bottom.branch[node]];
    for (std::int32_t i = branch.begin; i < branch.end; ++i) {
      bottom_of_frame_[frame_order_[i]] = node;
    }
  }
  for (int layer = layer_count() - 1; layer >= 1; --layer) {
    const Layer& below = layers_[layer];
    std::vector<std::int32_t>& above = layers_[layer - 1].node_of_bottom;
    above.reserve(below.node_of_bottom.size());
    for (std::int32_t node : below.node_of_bottom) above.push_back(below.parent[node]);
  }
}

int Tree::total_node_count() const {
  int count = 0;
  for (const Layer& layer : layers_) count += static_cast<int>(layer.branch.size());
  return count;
}

}  // namespace motiondb::core
