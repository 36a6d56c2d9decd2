#include "core/planning/segment_graph.h"

#include <algorithm>
#include <cmath>

#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr double kMaxRunSeconds = 0.25;
constexpr double kHalfWindowSeconds = 0.15;
constexpr double kMinHalfWindowShare = 0.5;  // of kHalfWindowSeconds: a shorter fade would jerk
// Maximum number of runs of a node considered for joins, and of joins kept. More do not improve
// plans in the same time.
constexpr std::size_t kMaxCandidates = 64;
constexpr std::size_t kMaxJoins = 16;
// Maximum mean squared difference of similar states, in squared standard deviations.
constexpr double kSimilar = 0.25;
constexpr double kRoughlySimilar = 0.75;
// Of joins that lead to nearly the same pose after a second only the best is kept: otherwise ten
// joins straight ahead would displace the one that turns. In leg lengths and radians together.
constexpr double kFutureSeconds = 1.0;
constexpr double kSameFuture = 0.95;
constexpr int kCoarseStep = 4;  // stride of the first comparison

}  // namespace

SegmentGraph::SegmentGraph(const Model& model, const StoredFloor& floor, int layer,
                           const Playable& playable, Similarity likeness)
    : model_(model),
      floor_(floor),
      largest_distance_(likeness == Similarity::kSimilar ? kSimilar : kRoughlySimilar),
      runs_of_node_(static_cast<std::size_t>(model.tree().node_count(layer))) {
  const double rate = model.settings().frame_rate_hz;
  const int max_frames = std::max(2, static_cast<int>(std::lround(kMaxRunSeconds * rate)));
  half_window_ = std::max(1, static_cast<int>(std::lround(kHalfWindowSeconds * rate)));
  ranges_ = PlayableRanges(model, playable);
  for (std::size_t r = 0; r < ranges_.size(); ++r) {
    const int end = ranges_[r].end;
    for (int first = ranges_[r].first; first < end;) {
      const int node = model.tree().node_of_frame(layer, first);
      int last = first;
      while (last + 1 < end && last + 1 - first < max_frames &&
             model.tree().node_of_frame(layer, last + 1) == node) {
        ++last;
      }
      runs_of_node_[node].push_back(static_cast<std::int32_t>(runs_.size()));
      runs_.push_back({first, last, node, last + 1 < end});
      range_of_run_.push_back(static_cast<std::int32_t>(r));
      first = last + 1;
    }
  }
}

int SegmentGraph::run_of_frame(int frame) const {
  const auto after = std::upper_bound(runs_.begin(), runs_.end(), frame,
                                      [](int f, const Run& run) { return f < run.first; });
  if (after == runs_.begin() || std::prev(after)->last < frame) return -1;
  return static_cast<int>(after - runs_.begin()) - 1;
}

bool SegmentGraph::IsFreeOfGlitches(int run) const {
  return !model_.HasGlitch(runs_[run].first, runs_[run].last);
}

double SegmentGraph::StateDistance(int a, int b) const {
  return static_cast<double>((model_.states().row(a) - model_.states().row(b)).squaredNorm() /
                             static_cast<float>(model_.states().cols()));
}

int SegmentGraph::HalfWindowAt(const PlayableRange& from, int leave, const PlayableRange& to,
                               int enter) const {
  return std::min({half_window_, leave - from.first, from.end - 1 - leave, enter - to.first,
                   to.end - 1 - enter});
}

std::optional<RunJoin> SegmentGraph::BestJoin(int from, int to) {
  const Run& a = runs_[from];
  const Run& b = runs_[to];
  const PlayableRange& leaving = RangeOf(from);
  const PlayableRange& entering = RangeOf(to);
  RunJoin best;
  best.distance = largest_distance_;
  bool found = false;
  const auto min_window = static_cast<int>(std::ceil(kMinHalfWindowShare * half_window_));
  const auto consider = [&](int leave, int enter) {
    const int window = HalfWindowAt(leaving, leave, entering, enter);
    if (window < min_window) return;
    const double distance = StateDistance(leave, enter);
    if (distance >= best.distance) return;
    best.join = {leave, enter, window};
    best.distance = distance;
    found = true;
  };
  for (int f = a.first; f <= a.last; f += kCoarseStep) {
    for (int g = b.first; g <= b.last; g += kCoarseStep) consider(f, g);
  }
  if (!found) return std::nullopt;
  const Join coarse = best.join;
  for (int f = std::max(a.first, coarse.leave - kCoarseStep + 1);
       f <= std::min(a.last, coarse.leave + kCoarseStep - 1); ++f) {
    for (int g = std::max(b.first, coarse.enter - kCoarseStep + 1);
         g <= std::min(b.last, coarse.enter + kCoarseStep - 1); ++g) {
      consider(f, g);
    }
  }
  const auto& [leave, enter, window] = best.join;
  if (model_.HasGlitch(leave - window, leave + window) ||
      model_.HasGlitch(enter - window, enter + window)) {
    return std::nullopt;
  }
  best.to = to;
  best.across = AcrossJoin(floor_, best.join);
  return best;
}

const std::vector<RunJoin>& SegmentGraph::Joins(int run) {
  const auto [known, is_new] = joins_.try_emplace(run);
  if (!is_new) return known->second;
  std::vector<RunJoin> joins;
  const std::vector<std::int32_t>& same_node = runs_of_node_[runs_[run].node];
  // An even sample, if the node has more runs.
  const std::size_t sampled = std::min(same_node.size(), kMaxCandidates);
  for (std::size_t i = 0; i < sampled; ++i) {
    const int to = same_node[i * same_node.size() / sampled];
    // A nearby run of the same clip would only repeat the motion or stall.
    const bool neighbour = RangeOf(to).clip == RangeOf(run).clip &&
                           std::abs(runs_[to].first - runs_[run].first) <= 4 * half_window_;
    if (neighbour || !IsFreeOfGlitches(to)) continue;
    if (auto join = BestJoin(run, to)) joins.push_back(*join);
  }
  std::stable_sort(joins.begin(), joins.end(),
                   [](const RunJoin& a, const RunJoin& b) { return a.distance < b.distance; });
  return known->second = KeepDistinctFutures(std::move(joins));
}

FloorPose SegmentGraph::Future(const RunJoin& join) const {
  const int frame = join.join.enter;
  const int end = RangeOf(join.to).end - 1;
  const auto ahead = static_cast<int>(kFutureSeconds * model_.settings().frame_rate_hz);
  return floor_.Between(frame, std::min(end, frame + ahead));
}

std::vector<RunJoin> SegmentGraph::KeepDistinctFutures(std::vector<RunJoin> joins) const {
  std::vector<RunJoin> kept;
  std::vector<FloorPose> futures;
  for (const RunJoin& join : joins) {
    const FloorPose future = Future(join);
    const bool known = std::any_of(futures.begin(), futures.end(), [&](const FloorPose& other) {
      return std::hypot((future.x - other.x) / floor_.leg_length_m(),
                        (future.y - other.y) / floor_.leg_length_m(),
                        future.heading - other.heading) < kSameFuture;
    });
    if (known) continue;
    kept.push_back(join);
    futures.push_back(future);
    if (kept.size() == kMaxJoins) break;
  }
  return kept;
}

}  // namespace motiondb::core
