#include "core/model/metric_frames.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/model/clip_graphs.h"
#include "core/model/model.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

constexpr int kBlockRows = 256;  // gathered states stay in the processor cache

// Projects `rows` of the states into the first rows of `projected`.
void ProjectRows(const MotionMetric& metric, const SharedRows& states, std::span<const int> rows,
                 FrameMatrix& projected, const ParallelFor& parallel) {
  const auto count = static_cast<int>(rows.size());
  parallel((count + kBlockRows - 1) / kBlockRows, [&](int block) {
    const int first = block * kBlockRows;
    FrameMatrix gathered(std::min(kBlockRows, count - first), states.cols());
    for (Eigen::Index r = 0; r < gathered.rows(); ++r) {
      gathered.row(r) = states.row(rows[first + r]) - metric.mean;
    }
    projected.middleRows(first, gathered.rows()) = RowProduct(gathered, metric.projection);
  });
}

}  // namespace

FrameMatrix Project(const MotionMetric& metric, const Eigen::Ref<const FrameMatrix>& states) {
  return RowProduct(states.rowwise() - metric.mean, metric.projection);
}

MetricFrames ProjectStored(const ModelParts& parts, const MetricFrames& known,
                           const ParallelFor& parallel) {
  MetricFrames frames;
  if (parts.metric.empty()) return frames;
  frames.rows = StrideFrames(parts.clips, parts.settings.frame_rate_hz);
  const auto added = std::span(frames.rows.frame).subspan(known.projected.rows());
  const bool is_first = known.projected.rows() == 0;
  const Eigen::Index room = is_first ? RoomToGrow(std::ssize(added)) : 0;
  FrameMatrix projected(std::ssize(added) + room, parts.metric.projection.cols());
  ProjectRows(parts.metric, parts.states, added, projected, parallel);
  const Eigen::VectorXf added_norms = projected.topRows(std::ssize(added)).rowwise().squaredNorm();
  frames.projected = is_first ? SharedRows(std::move(projected), room)
                              : known.projected.WithMore(std::move(projected));
  frames.squared_norms.resize(frames.projected.rows());
  frames.squared_norms << known.squared_norms, added_norms;
  return frames;
}

int FrameStride(double frame_rate_hz) {
  return std::max(1, static_cast<int>(std::lround(frame_rate_hz / 30)));
}

StridedFrames StrideFrames(const std::vector<ModelClip>& clips, double frame_rate_hz) {
  const int stride = FrameStride(frame_rate_hz);
  StridedFrames strided;
  for (const ModelClip& clip : clips) {
    strided.begin.push_back(static_cast<int>(strided.frame.size()));
    for (int f = 0; f < clip.frame_count; f += stride) {
      strided.frame.push_back(clip.first_frame + f);
    }
  }
  strided.begin.push_back(static_cast<int>(strided.frame.size()));
  return strided;
}

FrameMatrix SquaredDistances(const Eigen::Ref<const FrameMatrix>& a,
                             const Eigen::Ref<const FrameMatrix>& b,
                             const Eigen::Ref<const Eigen::VectorXf>& b_squared_norms) {
  FrameMatrix squared = -2 * a * b.transpose();
  squared.colwise() += a.rowwise().squaredNorm();
  squared.rowwise() += b_squared_norms.transpose();
  return squared.cwiseMax(0);
}

namespace {

// Every indexed node is compared with every observed frame, so their number is limited.
constexpr int kMaxNodes = 2048;

int IndexedLayer(const Tree& tree) {
  int layer = tree.layer_count();
  while (layer > 1 && tree.node_count(layer) > kMaxNodes) --layer;
  return layer;
}

}  // namespace

ClipIndex ClipIndex::Of(const ModelParts& parts) {
  ClipIndex index;
  if (parts.metric.empty()) return index;
  const int layer = IndexedLayer(parts.tree);
  const int nodes = parts.tree.node_count(layer);
  for (int node = 0; node < nodes; ++node) {
    index.branches_.push_back(parts.tree.branch(layer, node));
  }
  index.means_ = index.MeansIn(parts.metric, parts.gaussians);
  index.squared_norms_ = index.means_.rowwise().squaredNorm();

  std::vector<std::vector<int>> of_node(nodes);
  for (std::size_t clip = 0; clip < parts.clip_graphs.size(); ++clip) {
    for (const int node : NodesAbove(parts.tree, layer, parts.clip_graphs[clip]->nodes)) {
      std::vector<int>& clips = of_node[node];
      if (clips.empty() || clips.back() != static_cast<int>(clip)) {
        clips.push_back(static_cast<int>(clip));
      }
    }
  }
  for (const std::vector<int>& clips : of_node) {
    index.begin_.push_back(static_cast<int>(index.clips_.size()));
    index.clips_.insert(index.clips_.end(), clips.begin(), clips.end());
  }
  index.begin_.push_back(static_cast<int>(index.clips_.size()));
  return index;
}

ClipIndex ClipIndex::Restricted(const std::vector<bool>& allowed) const {
  ClipIndex restricted;
  std::vector<int> nodes;
  restricted.begin_.push_back(0);
  for (int node = 0; node < node_count(); ++node) {
    for (const int clip : clips(node)) {
      if (allowed[static_cast<std::size_t>(clip)]) restricted.clips_.push_back(clip);
    }
    const auto end = static_cast<int>(restricted.clips_.size());
    if (end == restricted.begin_.back()) continue;
    nodes.push_back(node);
    restricted.begin_.push_back(end);
    restricted.branches_.push_back(branches_[node]);
  }
  restricted.means_ = means_(nodes, Eigen::all);
  restricted.squared_norms_ = squared_norms_(nodes);
  return restricted;
}

FrameMatrix ClipIndex::MeansIn(const MotionMetric& metric, const NodeGaussians& gaussians) const {
  return Project(metric, gaussians.means()(branches_, Eigen::all));
}

}  // namespace motiondb::core
