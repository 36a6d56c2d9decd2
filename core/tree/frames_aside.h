// The frames that nodes were divided without (core/tree/divide_node.h), on their way down the tree
// while it is being built.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/divide_node.h"
#include "core/tree/tree.h"

namespace motiondb::core {

class FramesAside {
 public:
  // Those of a branch: what stands at its places, but for those that were divided.
  void Add(std::int32_t branch, const NodePlaces& places, const NodePlaces& divided,
           const std::vector<std::int32_t>& order);
  // Sends those of a branch that has been divided to the sides of its plane where they lie.
  void PassDown(std::int32_t branch, const Branch& divided, const SplitPlane& plane,
                const Eigen::Ref<const FrameMatrix>& states);
  // Puts all that came to a leaf behind its frames, and makes the branches' ranges those of an
  // order of all frames.
  void PutBack(std::vector<Branch>& branches, std::vector<std::int32_t>& order) const;

 private:
  std::map<std::int32_t, std::vector<std::int32_t>> of_branch_;
};

}  // namespace motiondb::core
