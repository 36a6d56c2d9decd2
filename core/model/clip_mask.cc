#include "core/model/clip_mask.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/model/clip_graphs.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<std::shared_ptr<const ClipMask>> ClipMask::Create(const Model& model,
                                                                 std::vector<bool> allowed) {
  if (allowed.size() != model.clips().size()) {
    return InvalidArgument("clip mask: expected {} clips, got {}", model.clips().size(),
                           allowed.size());
  }
  if (std::ranges::find(allowed, true) == allowed.end()) {
    return WithReason("FILTER_MATCHES_NOTHING",
                      FailedPrecondition("no clip of the model passes the filter; the model has {}",
                                         model.clips().size()));
  }
  return std::shared_ptr<const ClipMask>(new ClipMask(model, std::move(allowed)));
}

ClipMask::ClipMask(const Model& model, std::vector<bool> allowed)
    : model_(model), allowed_(std::move(allowed)) {
  for (std::size_t c = 0; c < allowed_.size(); ++c) {
    if (allowed_[c]) clips_.push_back(static_cast<int>(c));
  }
}

void ClipMask::SortFrames() const {
  std::vector<bool> is_allowed(static_cast<std::size_t>(model_.frame_count()));
  for (const int c : clips_) {
    const ModelClip& clip = model_.clips()[c];
    std::fill_n(is_allowed.begin() + clip.first_frame, clip.frame_count, true);
  }
  const std::vector<std::int32_t>& order = model_.tree().frame_order();
  before_.reserve(order.size() + 1);
  for (const std::int32_t frame : order) {
    before_.push_back(static_cast<std::int32_t>(frames_.size()));
    if (is_allowed[frame]) frames_.push_back(frame);
  }
  before_.push_back(static_cast<std::int32_t>(frames_.size()));
  for (const Branch& branch : model_.tree().branches()) {
    has_frames_.push_back(before_[branch.begin] < before_[branch.end]);
  }
}

std::span<const std::int32_t> ClipMask::frames(int branch) const {
  if (allows_all()) return AllowedFrames(model_, branch, nullptr);
  std::call_once(frames_once_, [this] { SortFrames(); });
  const Branch& all = model_.tree().branches()[branch];
  return std::span(frames_).subspan(before_[all.begin], before_[all.end] - before_[all.begin]);
}

bool ClipMask::has_frames(int branch) const {
  if (allows_all()) return true;
  std::call_once(frames_once_, [this] { SortFrames(); });
  return has_frames_[branch];
}

const TransitionGraph& ClipMask::global_graph(int layer) const {
  if (allows_all()) return model_.global_graph(layer);
  std::call_once(graphs_once_, [this] {
    std::vector<const ClipGraph*> of_clips;
    for (const int clip : clips_) of_clips.push_back(model_.parts().clip_graphs[clip].get());
    graphs_ = SumClipGraphs(model_.tree(), of_clips);
  });
  return graphs_[static_cast<std::size_t>(layer) - 1];
}

const std::shared_ptr<const LabelUnits>& ClipMask::action_units() const {
  if (allows_all()) return model_.action_units();
  std::call_once(units_once_, [this] {
    units_ = std::make_shared<const LabelUnits>(model_.clips(), model_.settings().frame_rate_hz,
                                                kActionTrack, this);
  });
  return units_;
}

const ClipIndex& ClipMask::clip_index() const {
  if (allows_all()) return model_.clip_index();
  std::call_once(index_once_, [this] { index_ = model_.clip_index().Restricted(allowed_); });
  return index_;
}

std::vector<int> AllowedClips(const Model& model, const ClipMask* mask) {
  if (mask != nullptr) return mask->clips();
  std::vector<int> all(model.clips().size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

int AllowedCount(const Model& model, const ClipMask* mask) {
  return static_cast<int>(mask == nullptr ? model.clips().size() : mask->clips().size());
}

std::span<const std::int32_t> AllowedFrames(const Model& model, int branch, const ClipMask* mask) {
  if (mask != nullptr) return mask->frames(branch);
  const Branch& all = model.tree().branches()[branch];
  return std::span(model.tree().frame_order()).subspan(all.begin, all.end - all.begin);
}

bool IsAllowedNode(const Model& model, int layer, int node, const ClipMask* mask) {
  return mask == nullptr || mask->has_frames(model.tree().branch(layer, node));
}

const TransitionGraph& AllowedGraph(const Model& model, int layer, const ClipMask* mask) {
  return mask == nullptr ? model.global_graph(layer) : mask->global_graph(layer);
}

const ClipIndex& AllowedIndex(const Model& model, const ClipMask* mask) {
  return mask == nullptr ? model.clip_index() : mask->clip_index();
}

}  // namespace motiondb::core
