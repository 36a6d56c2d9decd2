#include "core/recognition/shortlist.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr int kMaxSearchedFrames = 24;
constexpr int kNearNodes = 64;

}  // namespace

bool ListsAll(int clip_count, std::size_t max_clips) {
  return static_cast<std::size_t>(clip_count) <= max_clips;
}

std::vector<int> ShortlistFrames(int frames) { return SpreadEvenly(frames, kMaxSearchedFrames); }

NearClipFinder::NearClipFinder(const ClipIndex& index, int clip_count)
    : index_(index), nodes_(std::min(kNearNodes, index.node_count())), found_by_(clip_count, -1) {
  std::iota(nodes_.begin(), nodes_.end(), 0);
}

void NearClipFinder::Find(const Eigen::Ref<const Eigen::RowVectorXf>& squared_distances,
                          std::vector<NearClip>& near) {
  near.clear();
  const auto& distance = squared_distances;
  const auto nodes = static_cast<int>(nodes_.size());
  // Upper bound of their distances, from the nearest nodes of the previous frame.
  float bound = distance[nodes_[0]];
  for (int n = 1; n < nodes; ++n) bound = std::max(bound, distance[nodes_[n]]);
  std::vector<int> within;
  for (int node = 0; node < index_.node_count(); ++node) {
    if (distance[node] <= bound) within.push_back(node);
  }
  std::partial_sort(within.begin(), within.begin() + nodes, within.end(), [&](int a, int b) {
    return std::pair(distance[a], a) < std::pair(distance[b], b);
  });
  std::copy_n(within.begin(), nodes, nodes_.begin());
  const float max_distance = distance[nodes_[nodes - 1]];
  for (int n = 0; n < nodes; ++n) {
    for (const int clip : index_.clips(nodes_[n])) {
      if (found_by_[clip] == frame_) continue;  // a nearer node has this clip
      found_by_[clip] = frame_;
      near.push_back({clip, max_distance - distance[nodes_[n]]});
    }
  }
  ++frame_;
}

void ClipRanking::Add(const std::vector<NearClip>& near) {
  for (const auto& [clip, nearer] : near) {
    if (!is_found_[clip]) found_.push_back(clip);
    is_found_[clip] = true;
    nearer_[clip] += nearer;
  }
}

std::vector<int> ClipRanking::TakeShortlist(const ClipMask* mask, std::size_t max_clips) {
  std::vector<int> shortlist = found_;
  const auto kept = std::min(max_clips, shortlist.size());
  std::partial_sort(
      shortlist.begin(), shortlist.begin() + static_cast<std::ptrdiff_t>(kept), shortlist.end(),
      [&](int a, int b) { return std::pair(-nearer_[a], a) < std::pair(-nearer_[b], b); });
  shortlist.resize(kept);
  // Fill a short list with other clips: comparing more clips costs little.
  for (int clip = 0; clip < static_cast<int>(nearer_.size()) && shortlist.size() < max_clips;
       ++clip) {
    if (!is_found_[clip] && Allows(mask, clip)) shortlist.push_back(clip);
  }
  for (const int clip : found_) {
    nearer_[clip] = 0;
    is_found_[clip] = false;
  }
  found_.clear();
  return shortlist;
}

std::vector<int> ShortlistClips(const Model& model, const MotionMetric* own,
                                const FrameMatrix& observed, const ClipMask* mask,
                                std::size_t max_clips) {
  const auto clip_count = static_cast<int>(model.clips().size());
  if (ListsAll(AllowedCount(model, mask), max_clips)) {
    return ClipRanking(clip_count).TakeShortlist(mask, max_clips);
  }
  const ClipIndex& index = AllowedIndex(model, mask);
  const FrameMatrix frames =
      observed(ShortlistFrames(static_cast<int>(observed.rows())), Eigen::all);
  const FrameMatrix own_means =
      own == nullptr ? FrameMatrix() : index.MeansIn(*own, model.gaussians());
  const FrameMatrix distances =
      own == nullptr ? SquaredDistances(frames, index.means(), index.squared_norms())
                     : SquaredDistances(frames, own_means, own_means.rowwise().squaredNorm());
  NearClipFinder finder(index, clip_count);
  ClipRanking ranking(clip_count);
  std::vector<NearClip> near;
  for (Eigen::Index t = 0; t < distances.rows(); ++t) {
    finder.Find(distances.row(t), near);
    ranking.Add(near);
  }
  return ranking.TakeShortlist(mask, max_clips);
}

}  // namespace motiondb::core
