// The clips of a model that a query uses. The others count as if they were not stored: not as
// evidence, transitions, nodes, labels or nearest motion. Tree, node statistics, scales, metric and
// calibration stay those of all clips.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/graph/transition_graph.h"
#include "core/model/label_units.h"
#include "core/model/metric_frames.h"
#include "core/model/model.h"

namespace motiondb::core {

// Immutable and thread-safe, so queries share it. Derived data is computed on first use, once.
// Queries take a mask of their own model; null means all clips.
class ClipMask {
 public:
  // `allowed`: one for each clip. The model must outlive the mask. O(clips). FAILED_PRECONDITION
  // with reason FILTER_MATCHES_NOTHING if no clip is allowed; INVALID_ARGUMENT if the number of
  // clips differs.
  static absl::StatusOr<std::shared_ptr<const ClipMask>> Create(const Model& model,
                                                                std::vector<bool> allowed);
  ClipMask(const ClipMask&) = delete;
  ClipMask& operator=(const ClipMask&) = delete;

  bool allows(int clip) const { return allowed_[static_cast<std::size_t>(clip)]; }
  // Allowed clips, ascending; not empty.
  const std::vector<int>& clips() const { return clips_; }

  // Frames of the allowed clips under a branch of the tree, in the tree's order. The first call is
  // O(frames).
  std::span<const std::int32_t> frames(int branch) const;
  // Whether there are any. Faster than `frames`.
  bool has_frames(int branch) const;
  // Graph of one layer over the allowed clips. The first call computes all layers: O(edges of the
  // allowed clips, and of the graphs).
  const TransitionGraph& global_graph(int layer) const;
  // Units of kActionTrack of the allowed clips. The first call is O(clips).
  const std::shared_ptr<const LabelUnits>& action_units() const;
  // Index of the nodes that contain frames of allowed clips. The first call is O(index).
  const ClipIndex& clip_index() const;

 private:
  ClipMask(const Model& model, std::vector<bool> allowed);
  bool allows_all() const { return clips_.size() == allowed_.size(); }
  void SortFrames() const;

  const Model& model_;
  const std::vector<bool> allowed_;
  std::vector<int> clips_;

  mutable std::once_flag frames_once_;
  mutable std::vector<std::int32_t> frames_;  // allowed frames in the tree's order
  mutable std::vector<std::int32_t>
      before_;                            // [place in the tree's order]: allowed frames before it
  mutable std::vector<bool> has_frames_;  // [branch]
  mutable std::once_flag graphs_once_;
  mutable std::vector<TransitionGraph> graphs_;  // [layer - 1]
  mutable std::once_flag units_once_;
  mutable std::shared_ptr<const LabelUnits> units_;
  mutable std::once_flag index_once_;
  mutable ClipIndex index_;
};

// The same of all clips if `mask` is null.
inline bool Allows(const ClipMask* mask, int clip) { return mask == nullptr || mask->allows(clip); }
std::vector<int> AllowedClips(const Model& model, const ClipMask* mask);
int AllowedCount(const Model& model, const ClipMask* mask);
std::span<const std::int32_t> AllowedFrames(const Model& model, int branch, const ClipMask* mask);
// Returns whether a node contains an allowed frame.
bool IsAllowedNode(const Model& model, int layer, int node, const ClipMask* mask);
const TransitionGraph& AllowedGraph(const Model& model, int layer, const ClipMask* mask);
const ClipIndex& AllowedIndex(const Model& model, const ClipMask* mask);

}  // namespace motiondb::core
