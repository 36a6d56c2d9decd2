#include "core/tree/permuted_states.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/tree/row_kernels.h"
#include "core/tree/split_node.h"

namespace motiondb::core {

namespace {

constexpr int kChunkRows = 4096;  // rows of a parallel chunk

// Calls body(begin, end) for chunks of [begin, end) in parallel. Results must not depend on chunks.
template <typename Body>
void InChunks(std::int32_t begin, std::int32_t end, const ParallelFor& parallel, const Body& body) {
  const int chunks = (end - begin + kChunkRows - 1) / kChunkRows;
  parallel(chunks, [&](int c) {
    const std::int32_t first = begin + c * kChunkRows;
    body(first, std::min(first + kChunkRows, end));
  });
}

}  // namespace

PermutedStates::PermutedStates(Eigen::Map<FrameMatrix> states) : rows_(states) {
  const Eigen::Index count = rows_.rows();
  order_.resize(static_cast<std::size_t>(count));
  std::iota(order_.begin(), order_.end(), 0);
  projections_.resize(order_.size());
  sorted_.resize(order_.size());
  scratch_.resize(order_.size());
  misplaced_.resize(order_.size());
}

// Each thread moves some of the columns of all rows along the cycles of the permutation.
void PermutedStates::Restore(const ParallelFor& parallel) {
  constexpr Eigen::Index kColumns = 64;
  const auto stripes = static_cast<int>((rows_.cols() + kColumns - 1) / kColumns);
  parallel(stripes, [&](int stripe) {
    const Eigen::Index first = stripe * kColumns;
    auto columns = rows_.middleCols(first, std::min(kColumns, rows_.cols() - first));
    std::vector<bool> is_there(order_.size());
    Eigen::RowVectorXf moving(columns.cols());
    Eigen::RowVectorXf displaced(columns.cols());
    for (std::size_t begin = 0; begin < order_.size(); ++begin) {
      if (is_there[begin]) continue;
      moving = columns.row(static_cast<Eigen::Index>(begin));
      for (auto to = static_cast<std::size_t>(order_[begin]); !is_there[to];
           to = static_cast<std::size_t>(order_[to])) {
        displaced = columns.row(static_cast<Eigen::Index>(to));
        columns.row(static_cast<Eigen::Index>(to)) = moving;
        is_there[to] = true;
        moving.swap(displaced);
      }
    }
  });
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

// Swaps the i-th row on the left that belongs to the right with the i-th on the right that belongs
// to the left: each row moves at most once, and swaps are independent.
void PermutedStates::MoveLeft(std::int32_t begin, std::int32_t end, int left,
                              const ParallelFor& parallel) {
  const double cut = sorted_[begin + left - 1];
  std::int32_t last_at_cut = -1;  // frames at the cut go left up to this frame number
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

int PermutedStates::Split(std::int32_t begin, std::int32_t end, int min_frames,
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

bool PermutedStates::ExcludeOutliers(std::int32_t& begin, std::int32_t& end,
                                     const ParallelFor& parallel) {
  const std::int32_t count = end - begin;
  const int left =
      MinimumErrorThreshold(std::span(sorted_).subspan(begin, static_cast<std::size_t>(count)));
  if (left == 0) return false;
  MoveLeft(begin, end, left, parallel);
  (left < count - left ? begin : end) = begin + left;
  return true;
}

namespace {

constexpr std::size_t kMaxCompared = 64;  // sorted by comparison up to this size
constexpr std::size_t kBucketValues = 4;  // average values of a bucket
constexpr std::size_t kLarge = 32768;     // buckets are filled in parallel from this size
constexpr int kRuns = 16;
constexpr std::size_t kLargeBuckets = 512;

// Maps a value to one of `count` buckets between minimum and maximum, monotonically.
struct Buckets {
  double minimum;
  double scale;
  std::size_t count;

  Buckets(std::span<const double> values, std::size_t buckets) : count(buckets) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    minimum = *low;
    scale = *high > minimum ? static_cast<double>(buckets) / (*high - minimum) : 0;
  }
  std::size_t operator()(double value) const {
    return std::min(static_cast<std::size_t>((value - minimum) * scale), count - 1);
  }
};

void SortSmall(std::span<double> values, std::span<double> scratch,
               std::vector<std::uint32_t>& ends) {
  if (values.size() <= kMaxCompared) {
    std::sort(values.begin(), values.end());
    return;
  }
  const Buckets bucket(values, values.size() / kBucketValues);
  if (bucket.scale == 0) return;
  ends.assign(bucket.count, 0);
  for (double v : values) ++ends[bucket(v)];
  std::uint32_t end = 0;
  for (std::uint32_t& e : ends) {
    const std::uint32_t begin = end;
    end += e;
    e = begin;
  }
  for (double v : values) scratch[ends[bucket(v)]++] = v;
  std::uint32_t begin = 0;
  for (const std::uint32_t e : ends) {
    std::sort(scratch.begin() + begin, scratch.begin() + e);
    begin = e;
  }
  std::copy(scratch.begin(), scratch.begin() + values.size(), values.begin());
}

}  // namespace

void SortValues(std::span<double> values, std::span<double> scratch, const ParallelFor& parallel) {
  std::vector<std::uint32_t> ends;
  if (values.size() < kLarge) {
    SortSmall(values, scratch, ends);
    return;
  }
  const Buckets bucket(values, kLargeBuckets);
  if (bucket.scale == 0) return;
  const auto run = [&](int r) {
    const std::size_t begin = values.size() * r / kRuns;
    return values.subspan(begin, values.size() * (r + 1) / kRuns - begin);
  };
  // Destination of each run's values in each bucket: behind those of previous runs.
  std::vector<std::vector<std::uint32_t>> place(kRuns);
  parallel(kRuns, [&](int r) {
    place[r].assign(kLargeBuckets, 0);
    for (double v : run(r)) ++place[r][bucket(v)];
  });
  std::vector<std::uint32_t> begins(kLargeBuckets + 1);
  std::uint32_t end = 0;
  for (std::size_t b = 0; b < kLargeBuckets; ++b) {
    begins[b] = end;
    for (int r = 0; r < kRuns; ++r) {
      const std::uint32_t count = place[r][b];
      place[r][b] = end;
      end += count;
    }
  }
  begins[kLargeBuckets] = end;
  parallel(kRuns, [&](int r) {
    for (double v : run(r)) scratch[place[r][bucket(v)]++] = v;
  });
  parallel(kRuns, [&](int r) {
    std::vector<std::uint32_t> small_ends;
    // Interleave buckets over runs: consecutive ones would give the full buckets in the middle to
    // one thread.
    for (std::size_t b = static_cast<std::size_t>(r); b < kLargeBuckets; b += kRuns) {
      const std::size_t begin = begins[b];
      const std::size_t count = begins[b + 1] - begin;
      SortSmall(scratch.subspan(begin, count), values.subspan(begin, count), small_ends);
      std::copy_n(scratch.begin() + begin, count, values.begin() + begin);
    }
  });
}

}  // namespace motiondb::core
