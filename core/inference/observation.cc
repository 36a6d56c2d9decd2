#include "core/inference/observation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/model/clip_mask.h"
#include "core/model/model.h"
#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<FrameMatrix> ScaledObservation(const Model& model,
                                              const StateSequence& observation) {
  if (observation.frame_count() == 0)
    return InvalidArgument("observation: expected at least one frame");
  if (observation.states.cols() != model.marker_set().dimension_count()) {
    return InvalidArgument("observation: expected states of {} numbers, got {}",
                           model.marker_set().dimension_count(), observation.states.cols());
  }
  if (std::abs(observation.frame_rate_hz - model.settings().frame_rate_hz) > 1e-6) {
    return InvalidArgument("observation: expected a frame rate of {} Hz, got {}",
                           model.settings().frame_rate_hz, observation.frame_rate_hz);
  }
  if (observation.states.array().isInf().any()) {
    return InvalidArgument("observation: expected finite numbers or NaN");
  }
  FrameMatrix scaled = observation.states;
  model.scale().Apply(scaled);
  return scaled;
}

namespace {

constexpr double kPoolMass = 0.99;  // probability covered by the first branches

// Early rejection: the dimensions that are checked first, and the tolerance for rounding.
constexpr Eigen::Index kFirstDimensions = 36;
constexpr double kRounding = 1 + 1e-4;

// Distances to one state over its present dimensions.
class StateDistance {
 public:
  StateDistance(const float* state, Eigen::Index dimensions)
      : state_(Eigen::Map<const Eigen::RowVectorXf>(state, dimensions)),
        present_(state_.array().isNaN().select(0.0F, Eigen::RowVectorXf::Ones(dimensions))),
        count_(std::max(1.0F, present_.sum())),
        is_complete_(!state_.hasNaN()),
        first_(std::min(kFirstDimensions, dimensions)) {
    state_ = state_.array().isNaN().select(0.0F, state_);
  }

  double To(const Eigen::Ref<const Eigen::RowVectorXf>& stored) const {
    if (is_complete_) return (stored - state_).squaredNorm() / count_;
    return (stored - state_).cwiseProduct(present_).squaredNorm() / count_;
  }

  // Whether the first dimensions alone prove a distance above `distance`.
  bool IsBeyond(double distance, const Eigen::Ref<const Eigen::RowVectorXf>& stored) const {
    const auto apart = stored.head(first_) - state_.head(first_);
    const float squares = is_complete_ ? apart.squaredNorm()
                                       : apart.cwiseProduct(present_.head(first_)).squaredNorm();
    return squares / count_ > distance * kRounding;
  }

 private:
  Eigen::RowVectorXf state_;    // 0 where missing
  Eigen::RowVectorXf present_;  // 1, or 0 where missing
  float count_;
  bool is_complete_;
  Eigen::Index first_;
};

}  // namespace

std::vector<int> ExemplarPool(const Model& model, int layer, const std::vector<NodeState>& now,
                              const ClipMask* mask, int min_frames) {
  std::vector<int> pool;
  double mass = 0;
  for (const NodeState& state : now) {
    if (mass >= kPoolMass) break;
    pool.push_back(model.tree().branch(layer, state.node));
    mass += state.probability;
  }
  const auto& branches = model.tree().branches();
  while (true) {
    std::sort(pool.begin(), pool.end());
    pool.erase(std::unique(pool.begin(), pool.end()), pool.end());
    // Remove branches whose ancestors are in the pool.
    std::erase_if(pool, [&](int b) {
      for (int up = branches[b].parent; up >= 0; up = branches[up].parent) {
        if (std::binary_search(pool.begin(), pool.end(), up)) return true;
      }
      return false;
    });
    std::size_t frames = 0;
    for (int b : pool) frames += AllowedFrames(model, b, mask).size();
    if (frames >= static_cast<std::size_t>(min_frames) || pool == std::vector<int>{0}) return pool;
    for (int& b : pool) b = std::max(branches[b].parent, 0);
  }
}

std::vector<Exemplar> NearestFrames(const Model& model, const std::vector<int>& branches,
                                    const float* state, int count, const ClipMask* mask,
                                    FrameRange without) {
  const StateDistance distance(state, model.states().cols());
  std::vector<std::pair<double, int>> nearest;
  // At 2 * max_kept frames, drop the farther half and reject frames beyond it from then on.
  const auto max_kept = static_cast<std::size_t>(std::max(1, count));
  double farthest = std::numeric_limits<double>::infinity();
  const auto keep_best = [&] {
    const auto last = nearest.begin() + static_cast<std::ptrdiff_t>(max_kept - 1);
    std::nth_element(nearest.begin(), last, nearest.end());
    farthest = last->first;
    nearest.resize(max_kept);
  };
  nearest.reserve(2 * max_kept);
  for (int b : branches) {
    for (const std::int32_t frame : AllowedFrames(model, b, mask)) {
      if (frame >= without.first && frame < without.end) continue;
      const auto stored = model.states().row(frame);
      if (distance.IsBeyond(farthest, stored)) continue;
      nearest.emplace_back(distance.To(stored), frame);
      if (nearest.size() == 2 * max_kept) keep_best();
    }
  }
  const auto kept = std::min<std::size_t>(count, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(kept),
                    nearest.end());
  nearest.resize(kept);
  std::vector<Exemplar> exemplars;
  if (nearest.empty()) return exemplars;
  const double closest = nearest.front().first;
  const double spread = std::max(nearest[kept / 2].first - closest, 1e-12);
  double sum = 0;
  for (const auto& [apart, frame] : nearest) {
    exemplars.push_back({frame, std::exp(-0.5 * (apart - closest) / spread)});
    sum += exemplars.back().weight;
  }
  for (Exemplar& exemplar : exemplars) exemplar.weight /= sum;
  return exemplars;
}

}  // namespace motiondb::core
