#include "core/tree/permuted_states.h"

#include <algorithm>
#include <numeric>

#include "core/tree/row_kernels.h"
#include "core/tree/sort_values.h"
#include "core/tree/threshold.h"

namespace motiondb::core {
namespace {

constexpr int kChunkRows = 4096;  // rows a thread takes at a time

// Calls body(begin, end) for [begin, end) in chunks, side by side. Nothing may depend on the
// chunks.
template <typename Body>
void InChunks(std::int32_t begin, std::int32_t end, const ParallelFor& parallel, const Body& body) {
  const int chunks = (end - begin + kChunkRows - 1) / kChunkRows;
  parallel(chunks, [&](int c) {
    const std::int32_t first = begin + c * kChunkRows;
    body(first, std::min(first + kChunkRows, end));
  });
}

}  // namespace

PermutedStates::PermutedStates(const Eigen::Ref<const FrameMatrix>& states,
                               const ParallelFor& parallel)
    : rows_(states.rows(), states.cols()) {
  const auto count = static_cast<std::int32_t>(states.rows());
  InChunks(0, count, parallel, [&](std::int32_t begin, std::int32_t end) {
    rows_.middleRows(begin, end - begin) = states.middleRows(begin, end - begin);
  });
  order_.resize(static_cast<std::size_t>(count));
  std::iota(order_.begin(), order_.end(), 0);
  projections_.resize(order_.size());
  sorted_.resize(order_.size());
  scratch_.resize(order_.size());
  misplaced_.resize(order_.size());
}

void PermutedStates::Project(std::int32_t begin, std::int32_t end, const NodeAxis& node,
                             const ParallelFor& parallel) {
  const auto dimensions = static_cast<int>(rows_.cols());
  Eigen::VectorXd axis = Eigen::VectorXd::Zero(PaddedDimensions(dimensions));
  axis.head(dimensions) = node.principal.axis;
  const double offset = node.mean.dot(node.principal.axis);
  InChunks(begin, end, parallel, [&](std::int32_t first, std::int32_t last) {
    ProjectRows(rows_.row(first).data(), last - first, dimensions, axis.data(),
                projections_.data() + first);
    for (std::int32_t i = first; i < last; ++i) sorted_[i] = projections_[i] -= offset;
  });
}

// Exchanges the i-th row on the left that belongs to the right with the i-th on the right that
// belongs to the left: each row moves once at most, and no two exchanges touch the same row.
void PermutedStates::MoveLeft(std::int32_t begin, std::int32_t end, int left,
                              const ParallelFor& parallel) {
  const double cut = sorted_[begin + left - 1];
  std::int32_t last_at_cut = -1;  // of the frames at the cut, those up to this one go left
  if (sorted_[begin + left] == cut) {
    const auto first = std::lower_bound(sorted_.begin() + begin, sorted_.begin() + end, cut);
    const auto rank = static_cast<std::size_t>(begin + left - 1 - (first - sorted_.begin()));
    std::vector<std::int32_t> at_cut;
    for (std::int32_t i = begin; i < end; ++i) {
      if (projections_[i] == cut) at_cut.push_back(order_[i]);
    }
    std::nth_element(at_cut.begin(), at_cut.begin() + rank, at_cut.end());
    last_at_cut = at_cut[rank];
  } else {
    last_at_cut = static_cast<std::int32_t>(order_.size());
  }
  const auto goes_left = [&](std::int32_t i) {
    return projections_[i] < cut || (projections_[i] == cut && order_[i] <= last_at_cut);
  };

  const std::int32_t middle = begin + left;
  std::int32_t pairs = 0;
  for (std::int32_t i = begin; i < middle; ++i) {
    if (!goes_left(i)) misplaced_[begin + pairs++] = i;
  }
  std::int32_t behind = begin + pairs;
  for (std::int32_t i = middle; i < end; ++i) {
    if (goes_left(i)) misplaced_[behind++] = i;
  }
  InChunks(0, pairs, parallel, [&](std::int32_t first, std::int32_t last) {
    for (std::int32_t p = first; p < last; ++p) {
      const std::int32_t a = misplaced_[begin + p];
      const std::int32_t b = misplaced_[begin + pairs + p];
      rows_.row(a).swap(rows_.row(b));
      std::swap(order_[a], order_[b]);
    }
  });
}

int PermutedStates::Divide(std::int32_t begin, std::int32_t end, int min_frames,
                           std::vector<float>& centred, const ParallelFor& parallel,
                           SplitPlane& plane) {
  const NodeRows rows{rows_.row(begin).data(), end - begin, static_cast<int>(rows_.cols())};
  const NodeAxis node = FindNodeAxis(rows, centred, parallel);
  Project(begin, end, node, parallel);
  const auto count = static_cast<std::size_t>(end - begin);
  const std::span<double> sorted = std::span(sorted_).subspan(begin, count);
  SortValues(sorted, std::span(scratch_).subspan(begin, count), parallel);
  const int left = MinimumErrorThreshold(sorted);
  if (left < min_frames || end - begin - left < min_frames) return 0;
  plane.axis = node.principal.axis.cast<float>();
  plane.threshold = node.mean.dot(node.principal.axis) + (sorted[left - 1] + sorted[left]) / 2;
  MoveLeft(begin, end, left, parallel);
  return left;
}

bool PermutedStates::SetAside(std::int32_t& begin, std::int32_t& end, const ParallelFor& parallel) {
  const std::int32_t count = end - begin;
  const int left =
      MinimumErrorThreshold(std::span(sorted_).subspan(begin, static_cast<std::size_t>(count)));
  if (left == 0) return false;
  MoveLeft(begin, end, left, parallel);
  (left < count - left ? begin : end) = begin + left;
  return true;
}

}  // namespace motiondb::core
