#include "core/observe/node_filter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

#include "core/model/clip_mask.h"
#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr double kLogZero = -std::numeric_limits<double>::infinity();

bool IsAllMissing(const float* state, Eigen::Index dimensions) {
  return std::all_of(state, state + dimensions, [](float x) { return std::isnan(x); });
}

}  // namespace

NodeFilter::NodeFilter(const Model& model, int layer, double transition_floor, const ClipMask* mask,
                       int max_candidates)
    : model_(model),
      layer_(layer),
      floor_(transition_floor),
      mask_(mask),
      graph_(AllowedGraph(model, layer, mask)),
      max_candidates_(max_candidates) {}

void NodeFilter::Advance(const float* state) {
  Step(state, next_);
  std::swap(now_, next_);
}

NodeState NodeFilter::Peek(const float* state) {
  Step(state, next_);
  const auto best = std::ranges::max_element(next_.probability);
  return {next_.nodes[static_cast<std::size_t>(best - next_.probability.begin())], *best};
}

void NodeFilter::KeepBest() {
  const auto limit = static_cast<std::size_t>(max_candidates_);
  if (limit == 0 || candidates_.nodes.size() <= limit) return;
  auto& [nodes, density] = candidates_;
  densities_.assign(density.begin(), density.end());
  std::nth_element(densities_.begin(), densities_.begin() + max_candidates_ - 1, densities_.end(),
                   std::greater<>());
  const double lowest = densities_[limit - 1];
  const auto above = std::count_if(densities_.begin(), densities_.begin() + max_candidates_,
                                   [&](double d) { return d > lowest; });
  // Ties at the lowest density: keep the first ones.
  std::size_t ties_left = limit - static_cast<std::size_t>(above);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (density[i] < lowest || (density[i] == lowest && ties_left == 0)) continue;
    if (density[i] == lowest) --ties_left;
    nodes[kept] = nodes[i];
    density[kept++] = density[i];
  }
  nodes.resize(kept);
  density.resize(kept);
}

void NodeFilter::Descend(const float* state) {
  const Tree& tree = model_.tree();
  candidates_.nodes.assign(1, 0);
  candidates_.log_density.assign(1, model_.gaussians().LogDensity(0, state));
  for (int layer = 1; layer < layer_; ++layer) {
    KeepBest();
    std::swap(above_, candidates_);
    candidates_.nodes.clear();
    candidates_.log_density.clear();
    for (std::size_t i = 0; i < above_.nodes.size(); ++i) {
      const int first = tree.first_child(layer, above_.nodes[i]);
      const int count = tree.child_count(layer, above_.nodes[i]);
      for (int c = first; c < first + count; ++c) {
        if (!IsAllowedNode(model_, layer + 1, c, mask_)) continue;
        candidates_.nodes.push_back(c);
        // A copy of a leaf keeps its density.
        candidates_.log_density.push_back(
            count == 1 ? above_.log_density[i]
                       : model_.gaussians().LogDensity(tree.branch(layer + 1, c), state));
      }
    }
  }
}

void NodeFilter::Follow() {
  leads_.clear();
  for (std::size_t i = 0; i < now_.nodes.size(); ++i) {
    const int from = now_.nodes[i];
    const double probability = now_.probability[i];
    leads_.emplace_back(floor_ * probability, from);
    const double share = probability / static_cast<double>(graph_.row_sum(from));
    for (const Edge& edge : graph_.row(from)) leads_.emplace_back(share * edge.count, edge.to);
  }
  // Merge entries of one node, keep the most probable, sort by node.
  const auto by_node = [](const auto& a, const auto& b) { return a.second < b.second; };
  std::sort(leads_.begin(), leads_.end(), by_node);
  std::size_t kept = 0;
  for (const auto& lead : leads_) {
    if (kept > 0 && leads_[kept - 1].second == lead.second) {
      leads_[kept - 1].first += lead.first;
    } else {
      leads_[kept++] = lead;
    }
  }
  leads_.resize(kept);
  const auto limit = std::min(kept, 2 * static_cast<std::size_t>(max_candidates_));
  std::nth_element(leads_.begin(), leads_.begin() + static_cast<std::ptrdiff_t>(limit),
                   leads_.end(), std::greater<>());
  leads_.resize(limit);
  std::sort(leads_.begin(), leads_.end(), by_node);
  candidates_.nodes.clear();
  for (const auto& lead : leads_) candidates_.nodes.push_back(lead.second);
  candidates_.log_density.assign(limit, 0.0);
}

void NodeFilter::Arrive() {
  const auto& to = candidates_.nodes;
  arriving_.assign(to.size(), 0.0);
  double sum = 0;
  for (std::size_t i = 0; i < now_.nodes.size(); ++i) {
    const double mass = now_.probability[i];
    if (mass <= 0) continue;
    sum += mass;
    const std::span<const Edge> row = graph_.row(now_.nodes[i]);
    const double share = mass / static_cast<double>(graph_.row_sum(now_.nodes[i]));
    auto edge = row.begin();
    for (std::size_t j = 0; j < to.size() && edge != row.end(); ++j) {
      edge = std::lower_bound(edge, row.end(), to[j],
                              [](const Edge& e, std::int32_t node) { return e.to < node; });
      if (edge != row.end() && edge->to == to[j]) {
        arriving_[j] += share * edge->count - floor_ * mass;
      }
    }
  }
  // Every pair has the floor; counted transitions replace it.
  for (double& arriving : arriving_) arriving = std::max(arriving + floor_ * sum, 0.0);
}

void NodeFilter::Step(const float* state, Distribution& next) {
  const bool is_first = now_.nodes.empty();
  const Eigen::Index dimensions = model_.gaussians().dimension_count();
  if (!is_first && max_candidates_ > 0 && IsAllMissing(state, dimensions)) {
    Follow();
  } else {
    Descend(state);
  }
  if (is_first) {
    arriving_.assign(candidates_.nodes.size(), 1.0);
  } else {
    Arrive();
  }
  if (!(*std::ranges::max_element(arriving_) > 0)) arriving_.assign(arriving_.size(), 1.0);
  // Densities relative to the maximum of the reachable candidates, so that at least one is 1.
  const auto& density = candidates_.log_density;
  double peak = kLogZero;
  for (std::size_t j = 0; j < density.size(); ++j) {
    if (arriving_[j] > 0) peak = std::max(peak, density[j]);
  }
  next.nodes.assign(candidates_.nodes.begin(), candidates_.nodes.end());
  next.probability.assign(arriving_.begin(), arriving_.end());
  double sum = 0;
  for (std::size_t j = 0; j < density.size(); ++j) {
    // If every density underflows to 0, the frame says nothing.
    if (std::isfinite(peak)) next.probability[j] *= std::exp(std::min(density[j] - peak, 0.0));
    sum += next.probability[j];
  }
  for (double& probability : next.probability) probability /= sum;
}

}  // namespace motiondb::core
