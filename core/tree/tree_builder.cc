#include "core/tree/tree_builder.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "core/tree/principal_axis.h"
#include "core/tree/threshold.h"

namespace motiondb::core {
namespace {

// Frames of a node are summed in this many runs at most, so that a large node uses every thread.
// The division depends on the node alone, never on the threads: the sums come out the same.
constexpr int kMaxRuns = 16;
constexpr int kMinRunFrames = 2048;
constexpr int kGatherFrames = 256;  // rows brought together at a time, to stay in cache

// Mean and covariance of a node's states.
class NodeMoments {
 public:
  NodeMoments(const FrameMatrix& states, std::span<const std::int32_t> frames)
      : states_(states), frames_(frames) {
    const int count = static_cast<int>(frames.size());
    runs_ = std::clamp(count / kMinRunFrames, 1, kMaxRuns);
    partial_.resize(runs_);
    mean_ = Eigen::RowVectorXd::Zero(states.cols());
    for (std::int32_t frame : frames) mean_ += states.row(frame).cast<double>();
    mean_ /= static_cast<double>(count);
  }

  int runs() const { return runs_; }
  const Eigen::RowVectorXd& mean() const { return mean_; }

  // Sums one run's outer products. Runs may be summed on different threads.
  void SumRun(int run) {
    const std::size_t begin = frames_.size() * run / runs_;
    const std::size_t end = frames_.size() * (run + 1) / runs_;
    partial_[run] = Eigen::MatrixXd::Zero(states_.cols(), states_.cols());
    JointMatrix rows(kGatherFrames, states_.cols());
    for (std::size_t at = begin; at < end; at += kGatherFrames) {
      const auto count = static_cast<Eigen::Index>(std::min<std::size_t>(kGatherFrames, end - at));
      for (Eigen::Index r = 0; r < count; ++r) {
        rows.row(r) = states_.row(frames_[at + r]).cast<double>() - mean_;
      }
      partial_[run].selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(count).transpose());
    }
  }

  // The covariance's lower triangle, up to the factor 1 / frames. All runs must have been summed.
  Eigen::MatrixXd TakeScatter() {
    for (int run = 1; run < runs_; ++run) partial_[0] += partial_[run];
    return std::move(partial_[0]);
  }

 private:
  const FrameMatrix& states_;
  std::span<const std::int32_t> frames_;
  int runs_ = 1;
  Eigen::RowVectorXd mean_;
  std::vector<Eigen::MatrixXd> partial_;
};

// Divides the frames of a node in place: those left of the threshold first, each side in frame
// order. Returns how many are on the left, 0 for a leaf.
int SplitFrames(const FrameMatrix& states, NodeMoments& moments, int min_frames,
                std::span<std::int32_t> frames) {
  const Eigen::VectorXd axis = PrincipalAxis(moments.TakeScatter());
  const double offset = moments.mean().dot(axis.transpose());
  std::vector<std::pair<double, std::int32_t>> projected;  // eq. 4
  projected.reserve(frames.size());
  for (std::int32_t frame : frames) {
    projected.emplace_back(states.row(frame).cast<double>().dot(axis.transpose()) - offset, frame);
  }
  std::sort(projected.begin(), projected.end());  // ties by frame order
  std::vector<double> values;
  values.reserve(projected.size());
  for (const auto& [value, frame] : projected) values.push_back(value);

  const int left = MinimumErrorThreshold(values);
  if (left < min_frames || static_cast<int>(frames.size()) - left < min_frames) return 0;
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = projected[i].second;
  std::sort(frames.begin(), frames.begin() + left);
  std::sort(frames.begin() + left, frames.end());
  return left;
}

}  // namespace

absl::StatusOr<Tree> BuildTree(const FrameMatrix& states, int min_frames,
                               const ParallelFor& parallel, const LayerDone& layer_done) {
  if (states.rows() == 0) return InvalidArgument("a tree needs at least one frame");
  if (min_frames < 2) return InvalidArgument("min_frames: expected at least 2, got {}", min_frames);

  std::vector<std::int32_t> order(static_cast<std::size_t>(states.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::vector<Branch> branches{{.begin = 0, .end = static_cast<std::int32_t>(order.size())}};

  std::vector<std::int32_t> open{0};  // branches of the lowest layer that may yet split
  for (int layer = 1; !open.empty(); ++layer) {
    const auto frames_of = [&](std::int32_t b) {
      return std::span(order).subspan(branches[b].begin, branches[b].end - branches[b].begin);
    };
    std::erase_if(open, [&](std::int32_t b) {
      return static_cast<int>(frames_of(b).size()) < 2 * min_frames;
    });

    // Nodes of many runs are summed first, their runs side by side; then every node is split.
    std::vector<std::unique_ptr<NodeMoments>> moments(open.size());
    std::vector<int> left_counts(open.size());
    std::vector<std::pair<std::size_t, int>> runs;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (frames_of(open[i]).size() < 2 * kMinRunFrames) continue;
      moments[i] = std::make_unique<NodeMoments>(states, frames_of(open[i]));
      for (int run = 0; run < moments[i]->runs(); ++run) runs.emplace_back(i, run);
    }
    parallel(static_cast<int>(runs.size()),
             [&](int r) { moments[runs[r].first]->SumRun(runs[r].second); });
    parallel(static_cast<int>(open.size()), [&](int i) {
      const auto frames = frames_of(open[i]);
      if (!moments[i]) {
        moments[i] = std::make_unique<NodeMoments>(states, frames);
        moments[i]->SumRun(0);
      }
      left_counts[i] = SplitFrames(states, *moments[i], min_frames, frames);
      moments[i].reset();
    });

    std::vector<std::int32_t> children;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (left_counts[i] == 0) continue;
      const std::int32_t b = open[i];
      const auto left = static_cast<std::int32_t>(branches.size());
      branches[b].left = left;
      branches[b].right = left + 1;
      const std::int32_t middle = branches[b].begin + left_counts[i];
      const std::int32_t below = branches[b].layer + 1;
      branches.push_back({.parent = b, .begin = branches[b].begin, .end = middle, .layer = below});
      branches.push_back({.parent = b, .begin = middle, .end = branches[b].end, .layer = below});
      children.push_back(left);
      children.push_back(left + 1);
    }
    open = std::move(children);
    if (layer_done && !layer_done(layer)) return absl::CancelledError("the build was cancelled");
  }
  return Tree::Create(std::move(order), std::move(branches));
}

}  // namespace motiondb::core
