#include "core/recognition/shortlist.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/model/even_spread.h"
#include "core/model/squared_distances.h"

namespace motiondb::core {
namespace {

constexpr std::size_t kMostClips = 64;
constexpr int kMostFrames = 24;
constexpr int kNearNodes = 64;

}  // namespace

std::vector<int> ShortlistClips(const Model& model, const FrameMatrix& observed,
                                const std::vector<bool>& left_out) {
  const ClipIndex& index = model.clip_index();
  const int near = std::min(kNearNodes, index.node_count());
  const FrameMatrix frames = observed(SpreadEvenly(observed.rows(), kMostFrames), Eigen::all);
  const FrameMatrix distances = SquaredDistances(frames, index.means(), index.squared_norms());

  // How much nearer than the 64th node of each frame, summed over the frames.
  std::vector<float> nearer(model.clips().size(), 0.0F);
  std::vector<int> found;
  std::vector<int> found_at(model.clips().size(), -1);  // the frame that found a clip last
  std::vector<int> nodes(index.node_count());
  for (int t = 0; t < static_cast<int>(frames.rows()); ++t) {
    const auto to = distances.row(t);
    std::iota(nodes.begin(), nodes.end(), 0);
    std::partial_sort(nodes.begin(), nodes.begin() + near, nodes.end(),
                      [&](int a, int b) { return std::pair(to[a], a) < std::pair(to[b], b); });
    const float furthest = to[nodes[near - 1]];
    for (int n = 0; n < near; ++n) {
      for (const int clip : index.clips(nodes[n])) {
        if (found_at[clip] == t) continue;  // a nearer node has it
        if (found_at[clip] < 0) found.push_back(clip);
        found_at[clip] = t;
        nearer[clip] += furthest - to[nodes[n]];
      }
    }
  }
  if (!left_out.empty()) std::erase_if(found, [&](int clip) { return left_out[clip]; });
  const auto kept = std::min(kMostClips, found.size());
  std::partial_sort(
      found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), found.end(),
      [&](int a, int b) { return std::pair(-nearer[a], a) < std::pair(-nearer[b], b); });
  found.resize(kept);
  // Where few were found nothing is lost by comparing some more.
  for (int clip = 0; clip < static_cast<int>(nearer.size()) && found.size() < kMostClips; ++clip) {
    if (found_at[clip] < 0 && (left_out.empty() || !left_out[clip])) found.push_back(clip);
  }
  return found;
}

}  // namespace motiondb::core
