#include "core/inference/exemplars.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace motiondb::core {
namespace {

constexpr double kPoolMass = 0.99;  // of the state's distribution

// Distances to one state over the numbers that it has.
class StateDistance {
 public:
  StateDistance(const float* state, Eigen::Index dimensions)
      : state_(Eigen::Map<const Eigen::RowVectorXf>(state, dimensions)),
        present_(state_.array().isNaN().select(0.0F, Eigen::RowVectorXf::Ones(dimensions))),
        count_(std::max(1.0F, present_.sum())) {
    state_ = state_.array().isNaN().select(0.0F, state_);
  }

  double To(const Eigen::Ref<const Eigen::RowVectorXf>& stored) const {
    return (stored - state_).cwiseProduct(present_).squaredNorm() / count_;
  }

 private:
  Eigen::RowVectorXf state_;    // 0 where missing
  Eigen::RowVectorXf present_;  // 1, or 0 where missing
  float count_;
};

}  // namespace

std::vector<int> ExemplarPool(const Model& model, int layer, const std::vector<NodeState>& now,
                              int least_frames) {
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
    // A branch under another one of the pool is already in it.
    std::erase_if(pool, [&](int b) {
      for (int up = branches[b].parent; up >= 0; up = branches[up].parent) {
        if (std::binary_search(pool.begin(), pool.end(), up)) return true;
      }
      return false;
    });
    int frames = 0;
    for (int b : pool) frames += branches[b].end - branches[b].begin;
    if (frames >= least_frames || pool == std::vector<int>{0}) return pool;
    for (int& b : pool) b = std::max(branches[b].parent, 0);
  }
}

std::vector<Exemplar> NearestFrames(const Model& model, const std::vector<int>& branches,
                                    const float* state, int count, FrameRange without) {
  const StateDistance distance(state, model.states().cols());
  std::vector<std::pair<double, int>> nearest;
  for (int b : branches) {
    const Branch& branch = model.tree().branches()[b];
    for (std::int32_t i = branch.begin; i < branch.end; ++i) {
      const int frame = model.tree().frame_order()[i];
      if (frame >= without.first && frame < without.end) continue;
      nearest.emplace_back(distance.To(model.states().row(frame)), frame);
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
