#include "core/recognition/cheapest_path.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "core/recognition/alignment_loops.h"

namespace motiondb::core {
namespace {

constexpr int kUnreachedRows = 2;

}  // namespace

bool CheapestPaths::Search(const MetricFrames& stored, RowRange rows,
                           ThrottledCancellation& cancellation) {
  count_ = rows.count;
  cost_.assign(kUnreachedRows + count_, std::numeric_limits<float>::infinity());
  next_cost_ = cost_;
  start_.assign(kUnreachedRows + count_, 0);
  next_start_ = start_;
  for (int block = 0; block < observed_.block_count(); ++block) {
    if (cancellation.cancelled(std::int64_t{count_} * stored.projected.cols())) return false;
    observed_.ComputeDistances(stored, rows, block, distances_);
    for (int f = 0; f < observed_.CountOf(block); ++f) {
      const float* const squared = distances_.col(f).data();
      if (block == 0 && f == 0) {
        std::copy_n(squared, count_, cost_.begin() + kUnreachedRows);
        std::iota(start_.begin() + kUnreachedRows, start_.end(), 0);
        continue;
      }
      ExtendCheapest(cost_.data(), start_.data(), squared, count_, kWarpCost,
                     next_cost_.data() + kUnreachedRows, next_start_.data() + kUnreachedRows);
      cost_.swap(next_cost_);
      start_.swap(next_start_);
    }
  }
  return true;
}

double CheapestPaths::least_cost() const {
  return double{*std::min_element(cost_.begin(), cost_.end())} / observed_.count();
}

std::vector<PathRows> CheapestPaths::Disjoint(int max_count) const {
  std::vector<int> ends(count_);
  std::iota(ends.begin(), ends.end(), 0);
  std::stable_sort(ends.begin(), ends.end(), [&](int a, int b) {
    return cost_[kUnreachedRows + a] < cost_[kUnreachedRows + b];
  });
  std::vector<PathRows> paths;
  std::map<int, int> taken;  // last row -> first row
  for (const int end : ends) {
    if (std::ssize(paths) >= max_count) break;
    const int first = start_[kUnreachedRows + end];
    const auto after = taken.lower_bound(first);  // the first taken path that ends at or after it
    if (after != taken.end() && after->second <= end) continue;
    taken[end] = first;
    paths.push_back({first, end, double{cost_[kUnreachedRows + end]} / observed_.count()});
  }
  return paths;
}

}  // namespace motiondb::core
