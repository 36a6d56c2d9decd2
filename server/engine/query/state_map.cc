#include "server/engine/query/state_map.h"

#include <algorithm>
#include <numeric>

#include "core/model/even_spread.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {
namespace {

constexpr int kMaxPoints = 100'000;

std::vector<int> NodesOf(const ModelLayer& layer) {
  const core::Model& model = layer.model();
  if (layer.clip >= 0) return model.clip_graph(layer.layer, layer.clip)->nodes;
  std::vector<int> nodes(static_cast<std::size_t>(model.tree().node_count(layer.layer)));
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

std::vector<int> PointsOf(const ModelLayer& layer, int max_points) {
  const core::Model& model = layer.model();
  const int first = layer.clip < 0 ? 0 : model.clips()[layer.clip].first_frame;
  const int frames = layer.clip < 0 ? model.frame_count() : model.clips()[layer.clip].frame_count;
  std::vector<int> points = core::SpreadEvenly(frames, std::min(max_points, kMaxPoints));
  for (int& point : points) point += first;
  return points;
}

}  // namespace

int StateMap::model_version() const {
  return snapshot().is_stored() ? snapshot().record.version : 0;
}

absl::StatusOr<std::shared_ptr<StateMap>> StateMap::Open(Engine& engine,
                                                         const LayerRequest& request,
                                                         int max_points, const WorkOptions& terms) {
  if (max_points < 0) {
    return core::FieldViolation("max_points", "expected at least 0, got {}", max_points);
  }
  MOTIONDB_ASSIGN_OR_RETURN(ModelLayer layer, FindLayer(engine, request, terms));
  MOTIONDB_ASSIGN_OR_RETURN(
      auto axes,
      layer.snapshot->view->Axes(layer.model(), engine.workers().Parallel(Pool::kRequests), terms));
  return std::shared_ptr<StateMap>(new StateMap(std::move(layer), std::move(axes), max_points));
}

StateMap::StateMap(ModelLayer layer, std::shared_ptr<const core::StateAxes> axes, int max_points)
    : layer_(std::move(layer)),
      axes_(std::move(axes)),
      nodes_(NodesOf(layer_)),
      transitions_(layer_),
      points_(PointsOf(layer_, max_points)),
      summaries_(layer_.model(), *axes_) {}

std::span<const int> StateMap::TakeNodes(std::size_t max_count) {
  constexpr int kMaxFrames = 1 << 17;
  const std::size_t first = node_;
  int frames = 0;
  while (node_ < nodes_.size() && node_ - first < max_count && frames < kMaxFrames) {
    const core::Branch& branch =
        model().tree().branches()[model().tree().branch(layer(), nodes_[node_++])];
    frames += branch.end - branch.begin;
  }
  return std::span(nodes_).subspan(first, node_ - first);
}

std::pair<int, int> StateMap::TakeTransitions(int max_count) {
  const int first = edge_;
  edge_ = std::min(transitions_.edge_count(), edge_ + max_count);
  return {first, edge_};
}

std::span<const int> StateMap::TakePoints(std::size_t max_count) {
  const auto points =
      std::span(points_).subspan(point_, std::min(points_.size() - point_, max_count));
  point_ += points.size();
  return points;
}

}  // namespace motiondb::server
