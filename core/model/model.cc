#include "core/model/model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/model/clip_graphs.h"
#include "core/model/label_units.h"
#include "core/motion/error.h"
#include "core/motion/mirror.h"

namespace motiondb::core {

bool ModelClip::HasGlitch(int first, int last) const {
  const auto overlap =
      std::ranges::lower_bound(glitches, first - first_frame, {}, &FrameSpan::last);
  return overlap != glitches.end() && overlap->first <= last - first_frame;
}
namespace {

absl::Status CheckFrames(const ModelParts& parts) {
  const auto frames = static_cast<int>(parts.states.rows());
  if (parts.tree.frame_count() != frames || parts.root_path.rows() != frames || frames == 0) {
    return DataLoss(
        "model: expected equal frame counts, got {} states, {} root poses, {} in the tree", frames,
        parts.root_path.rows(), parts.tree.frame_count());
  }
  if (parts.built_clip_count > std::ssize(parts.clips)) {
    return DataLoss("model: got {} built clips, but there are {} clips", parts.built_clip_count,
                    parts.clips.size());
  }
  const int dimensions = parts.marker_set.dimension_count();
  if (parts.states.cols() != dimensions || parts.scale.divisor.size() != dimensions ||
      parts.gaussians.dimension_count() != dimensions || !(parts.scale.divisor.array() > 0).all()) {
    return DataLoss("model: states, scale and statistics must have {} dimensions", dimensions);
  }
  int next = 0;
  for (const ModelClip& clip : parts.clips) {
    if (clip.first_frame != next || clip.frame_count < 1 || clip.frame_count > frames - next) {
      return DataLoss("model: clip '{}' does not begin where the previous clip ends", clip.id);
    }
    if (const absl::Status labels = clip.labels.Check(clip.frame_count); !labels.ok()) {
      return DataLoss("model: clip '{}': {}", clip.id, std::string(labels.message()));
    }
    next += clip.frame_count;
  }
  const Eigen::Index numbers = 3 * parts.marker_set.marker_count();
  const auto horizons = static_cast<Eigen::Index>(parts.prior.seconds.size());
  if (parts.prior.weights.cols() != horizons * numbers ||
      parts.prior.weights.rows() != (horizons == 0 ? 0 : (1 + kLags) * numbers)) {
    return DataLoss("model: the motion prior does not have the size for {} markers", numbers / 3);
  }
  if (next != frames) return DataLoss("model: clips contain {} of {} frames", next, frames);
  return absl::OkStatus();
}

absl::Status CheckMetric(const MotionMetric& metric, Eigen::Index dimensions) {
  if (metric.empty()) return absl::OkStatus();
  const bool fits = metric.mean.size() == dimensions && metric.loadings.rows() == dimensions &&
                    metric.whitening.rows() == dimensions &&
                    metric.whitening.cols() == dimensions &&
                    metric.projection.rows() == dimensions && metric.projection.cols() > 0;
  const bool finite = metric.mean.allFinite() && metric.loadings.allFinite() &&
                      metric.whitening.allFinite() && metric.projection.allFinite() &&
                      metric.noise > 0 && std::isfinite(metric.noise);
  if (fits && finite) return absl::OkStatus();
  return DataLoss("model: expected a finite metric with {} dimensions", dimensions);
}

bool Fits(const TransitionGraph& graph, int node_count) {
  return graph.node_count() == node_count &&
         std::all_of(graph.edges().begin(), graph.edges().end(), [&](const Edge& edge) {
           return edge.to >= 0 && edge.to < node_count && edge.count > 0;
         });
}

bool Fits(const ClipGraph& graph, int node_count) {
  const std::size_t states = graph.nodes.size();
  return states > 0 && graph.frames.size() == states && graph.nodes.front() >= 0 &&
         graph.nodes.back() < node_count &&
         std::is_sorted(graph.nodes.begin(), graph.nodes.end(), std::less_equal<>()) &&
         Fits(graph.transitions, static_cast<int>(states));
}

absl::Status CheckLayers(const ModelParts& parts) {
  const auto layers = static_cast<std::size_t>(parts.tree.layer_count());
  if (parts.gaussians.branch_count() != static_cast<int>(parts.tree.branches().size())) {
    return DataLoss("model: statistics for {} branches, but the tree has {}",
                    parts.gaussians.branch_count(), parts.tree.branches().size());
  }
  if (parts.global_graphs.size() != layers || parts.clip_graphs.size() != parts.clips.size() ||
      parts.familiarity.scores.size() != layers) {
    return DataLoss(
        "model: graphs or familiarity do not have the {} layers or the clips of the model", layers);
  }
  for (std::size_t l = 0; l < layers; ++l) {
    const int nodes = parts.tree.node_count(static_cast<int>(l) + 1);
    if (!Fits(parts.global_graphs[l], nodes)) {
      return DataLoss("model: the graph of layer {} does not fit its {} nodes", l + 1, nodes);
    }
  }
  const int nodes = parts.tree.node_count(parts.tree.layer_count());
  if (!std::ranges::all_of(parts.clip_graphs, [&](const auto& graph) {
        return graph != nullptr && Fits(*graph, nodes);
      })) {
    return DataLoss("model: the clips' graphs do not fit the bottom layer's {} nodes", nodes);
  }
  return absl::OkStatus();
}

absl::Status Check(const ModelParts& parts) {
  MOTIONDB_RETURN_IF_ERROR(CheckFrames(parts));
  MOTIONDB_RETURN_IF_ERROR(CheckLayers(parts));
  return CheckMetric(parts.metric, parts.states.cols());
}

void ResolveLabels(ModelParts& parts) {
  for (ModelClip& clip : parts.clips) clip.labels.Resolve(clip.frame_count);
}

std::shared_ptr<const LabelUnits> UnitsOfAction(const ModelParts& parts) {
  return std::make_shared<const LabelUnits>(parts.clips, parts.settings.frame_rate_hz,
                                            kActionTrack);
}

}  // namespace

Model::Model(ModelParts parts, const MetricFrames& known, const ParallelFor& parallel)
    : parts_(std::move(parts)),
      metric_frames_(ProjectStored(parts_, known, parallel)),
      clip_index_(ClipIndex::Of(parts_)),
      rigid_tree_(FindRigidTree(parts_)),
      other_sides_(OtherSides(parts_.marker_set.markers)),
      action_units_(UnitsOfAction(parts_)) {}

absl::StatusOr<Model> Model::Create(ModelParts parts, const ParallelFor& parallel) {
  ResolveLabels(parts);
  MOTIONDB_RETURN_IF_ERROR(Check(parts));
  return Model(std::move(parts), MetricFrames(), parallel);
}

absl::StatusOr<Model> Model::Create(ModelParts parts, const Model& base) {
  ResolveLabels(parts);
  MOTIONDB_RETURN_IF_ERROR(Check(parts));
  return Model(std::move(parts), base.metric_frames_, RunSerially);
}

absl::StatusOr<Model> Model::WithLabels(std::vector<ClipLabels> labels) const {
  if (labels.size() != parts_.clips.size()) {
    return InvalidArgument("labels: expected those of {} clips, got {}", parts_.clips.size(),
                           labels.size());
  }
  for (std::size_t c = 0; c < labels.size(); ++c) {
    const ModelClip& clip = parts_.clips[c];
    labels[c].labels.Resolve(clip.frame_count);
    if (const absl::Status fits = labels[c].labels.Check(clip.frame_count); !fits.ok()) {
      return InvalidArgument("clip '{}': {}", clip.id, std::string(fits.message()));
    }
  }
  Model relabelled = *this;
  for (std::size_t c = 0; c < labels.size(); ++c) {
    relabelled.parts_.clips[c].labels = std::move(labels[c].labels);
    relabelled.parts_.clips[c].subject = std::move(labels[c].subject);
  }
  relabelled.action_units_ = UnitsOfAction(relabelled.parts_);
  return relabelled;
}

std::shared_ptr<const ClipGraph> Model::clip_graph(int layer, int clip) const {
  const auto& bottom = parts_.clip_graphs[clip];
  if (layer == layer_count()) return bottom;
  return std::make_shared<const ClipGraph>(ClipGraphAbove(parts_.tree, layer, *bottom));
}

int Model::clip_of_frame(int frame) const {
  const auto after =
      std::upper_bound(parts_.clips.begin(), parts_.clips.end(), frame,
                       [](int f, const ModelClip& clip) { return f < clip.first_frame; });
  return static_cast<int>(after - parts_.clips.begin()) - 1;
}

bool Model::HasGlitch(int first, int last) const {
  return parts_.clips[clip_of_frame(first)].HasGlitch(first, last);
}

absl::StatusOr<int> Model::ResolveLayer(int layer) const {
  if (layer == 0) return layer_count();
  if (layer < 0 || layer > layer_count()) {
    return AtField("layer", absl::OutOfRangeError(fmt::format("layer: expected 1 to {}, got {}",
                                                              layer_count(), layer)));
  }
  return layer;
}

}  // namespace motiondb::core
