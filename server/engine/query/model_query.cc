#include "server/engine/query/model_query.h"

#include <algorithm>
#include <numeric>

#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/motion/samples.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {
namespace {

// Limits of one answer.
constexpr int kMaxPoses = 1000;
constexpr int kMaxPoseMarkers = 128 * 1024;  // 3 MiB

absl::Status CheckListed(const ModelStamp& listed, const ModelStamp& current) {
  if (listed.create_time_us == 0 ||
      (listed.version == current.version && listed.create_time_us == current.create_time_us)) {
    return absl::OkStatus();
  }
  return core::WithReason(
      "MODEL_REPLACED",
      absl::AbortedError(
          "the model was replaced while it was being listed; list again from the first page"));
}

absl::StatusOr<int> IndexOfClip(const Snapshot& snapshot, const std::string& database,
                                const std::string& clip) {
  if (clip.empty()) return -1;
  const auto& clips = snapshot.model.clips();
  const auto found = std::ranges::find(clips, clip, &core::ModelClip::id);
  if (found == clips.end()) {
    return core::WithReason("CLIP_NOT_FOUND",
                            core::NotFound("clip '{}' is not in model {} of database '{}'", clip,
                                           snapshot.record.version, database));
  }
  return static_cast<int>(found - clips.begin());
}

}  // namespace

absl::StatusOr<ListedModels> DescribeModel(Engine& engine, const std::string& database, int version,
                                           const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine.FindDatabase(database));
  if (version == 0) {
    MOTIONDB_ASSIGN_OR_RETURN(SnapshotPointer current, engine.CurrentModel(*live, terms));
    return ListedModels{{current->record}, live->settings(), std::move(current)};
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto record, engine.store().GetModel(database, version));
  MOTIONDB_ASSIGN_OR_RETURN(SnapshotPointer current, engine.ModelIfAny(*live, terms));
  return ListedModels{{std::move(record)}, live->settings(), std::move(current)};
}

absl::StatusOr<ListedModels> ListStoredModels(Engine& engine, const std::string& database,
                                              int before, int limit, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine.FindDatabase(database));
  MOTIONDB_ASSIGN_OR_RETURN(auto records, engine.store().ListModels(database, before, limit));
  MOTIONDB_ASSIGN_OR_RETURN(SnapshotPointer current, engine.ModelIfAny(*live, terms));
  return ListedModels{std::move(records), live->settings(), std::move(current)};
}

ModelStamp StampOf(const Snapshot& snapshot) {
  return {snapshot.record.version, snapshot.record.create_time_us};
}

absl::StatusOr<SnapshotPointer> FindReadableModel(Engine& engine, const std::string& database,
                                                  int version, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, engine.FindDatabase(database));
  MOTIONDB_ASSIGN_OR_RETURN(SnapshotPointer snapshot, engine.CurrentModel(*live, terms));
  const bool is_current = snapshot->is_stored() && version == snapshot->record.version;
  if (version == 0 || is_current) return snapshot;
  MOTIONDB_RETURN_IF_ERROR(engine.store().GetModel(database, version).status());
  return core::WithReason(
      "MODEL_SUPERSEDED",
      core::FailedPrecondition("model {} of database '{}' was replaced by a newer one, only its "
                               "statistics are stored: read databases/{}/models/current",
                               version, database, database));
}

const core::Model& ModelLayer::model() const { return snapshot->model; }

absl::StatusOr<ModelLayer> FindLayer(Engine& engine, const LayerRequest& request,
                                     const WorkOptions& terms) {
  // A later page reads the current model, and fails if that is another one.
  const int version = request.listed.create_time_us == 0 ? request.version : 0;
  ModelLayer found;
  MOTIONDB_ASSIGN_OR_RETURN(found.snapshot,
                            FindReadableModel(engine, request.database, version, terms));
  MOTIONDB_RETURN_IF_ERROR(CheckListed(request.listed, StampOf(*found.snapshot)));
  const auto layer = found.model().ResolveLayer(request.layer);
  if (!layer.ok()) return core::AtField("layer", layer.status());
  found.layer = *layer;
  MOTIONDB_ASSIGN_OR_RETURN(found.clip,
                            IndexOfClip(*found.snapshot, request.database, request.clip));
  return found;
}

absl::StatusOr<NodePoses> ReadNodePoses(Engine& engine, const LayerRequest& request,
                                        std::span<const int> nodes, const WorkOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const ModelLayer found, FindLayer(engine, request, terms));
  const core::Model& model = found.model();
  const int markers = model.marker_set().marker_count();
  const int max_nodes = std::min(kMaxPoses, kMaxPoseMarkers / markers);
  if (nodes.empty() || nodes.size() > static_cast<std::size_t>(max_nodes)) {
    return core::FieldViolation("node_ids", "expected 1 to {} nodes of {} markers, got {}",
                                max_nodes, markers, nodes.size());
  }
  NodePoses answer{.layer = found.layer};
  answer.poses.reserve(nodes.size());
  const int count = model.tree().node_count(found.layer);
  for (const int node : nodes) {
    if (node < 0 || node >= count) {
      return core::FieldViolation("node_ids", "expected 0 to {}, the last node of layer {}, got {}",
                                  count - 1, found.layer, node);
    }
    answer.poses.push_back({node, core::MeanPoseOf(model, found.layer, node)});
  }
  return answer;
}

TransitionList::TransitionList(const ModelLayer& layer)
    : clip_(layer.clip < 0 ? nullptr : layer.model().clip_graph(layer.layer, layer.clip)),
      graph_(clip_ == nullptr ? layer.model().global_graph(layer.layer) : clip_->transitions) {}

int TransitionList::edge_count() const { return graph_.edge_count(); }

Transition TransitionList::At(int edge) const {
  const auto& row_begin = graph_.row_begin();
  const int from =
      static_cast<int>(std::ranges::upper_bound(row_begin, edge) - row_begin.begin()) - 1;
  const core::Edge& seen = graph_.edges()[edge];
  const auto node_of = [&](int state) { return clip_ == nullptr ? state : clip_->nodes[state]; };
  return {node_of(from), node_of(seen.to), seen.count,
          static_cast<double>(seen.count) / static_cast<double>(graph_.row_sum(from))};
}

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
