#include "core/tree/frames_aside.h"

#include <algorithm>
#include <utility>

namespace motiondb::core {

void FramesAside::Add(std::int32_t branch, const NodePlaces& places, const NodePlaces& divided,
                      const std::vector<std::int32_t>& order) {
  if (divided.begin == places.begin && divided.end == places.end) return;
  std::vector<std::int32_t>& frames = of_branch_[branch];
  frames.insert(frames.end(), order.begin() + places.begin, order.begin() + divided.begin);
  frames.insert(frames.end(), order.begin() + divided.end, order.begin() + places.end);
}

void FramesAside::PassDown(std::int32_t branch, const Branch& divided, const SplitPlane& plane,
                           const Eigen::Ref<const FrameMatrix>& states) {
  const auto frames = of_branch_.extract(branch);
  if (frames.empty()) return;
  for (const std::int32_t frame : frames.mapped()) {
    const bool left = IsLeft(plane.axis, plane.threshold, states.row(frame));
    of_branch_[left ? divided.left : divided.right].push_back(frame);
  }
}

void FramesAside::PutBack(std::vector<Branch>& branches, std::vector<std::int32_t>& order) const {
  if (of_branch_.empty()) return;
  std::vector<std::int32_t> leaves;
  for (std::size_t b = 0; b < branches.size(); ++b) {
    if (branches[b].left < 0) leaves.push_back(static_cast<std::int32_t>(b));
  }
  std::ranges::sort(leaves, {}, [&](std::int32_t b) { return branches[b].begin; });
  std::vector<std::int32_t> whole;
  for (const std::int32_t b : leaves) {
    const auto first = static_cast<std::int32_t>(whole.size());
    whole.insert(whole.end(), order.begin() + branches[b].begin, order.begin() + branches[b].end);
    if (const auto added = of_branch_.find(b); added != of_branch_.end())
      whole.insert(whole.end(), added->second.begin(), added->second.end());
    branches[b].begin = first;
    branches[b].end = static_cast<std::int32_t>(whole.size());
  }
  for (std::size_t b = branches.size(); b-- > 0;) {  // children before their parents
    if (branches[b].left < 0) continue;
    branches[b].begin = branches[branches[b].left].begin;
    branches[b].end = branches[branches[b].right].end;
  }
  order = std::move(whole);
}

}  // namespace motiondb::core
