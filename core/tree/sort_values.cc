#include "core/tree/sort_values.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace motiondb::core {
namespace {

constexpr std::size_t kCompared = 64;     // so few are compared
constexpr std::size_t kBucketValues = 4;  // values a bucket on average
constexpr std::size_t kLarge = 32768;     // from here on the buckets are dealt side by side
constexpr int kRuns = 16;
constexpr std::size_t kLargeBuckets = 512;

// Which of `count` buckets between the least and the greatest value a value belongs to: never less
// for a greater value.
struct Buckets {
  double least;
  double scale;
  std::size_t count;

  Buckets(std::span<const double> values, std::size_t buckets) : count(buckets) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    least = *low;
    scale = *high > least ? static_cast<double>(buckets) / (*high - least) : 0;
  }
  std::size_t operator()(double value) const {
    return std::min(static_cast<std::size_t>((value - least) * scale), count - 1);
  }
};

void SortSmall(std::span<double> values, std::span<double> scratch,
               std::vector<std::uint32_t>& ends) {
  if (values.size() <= kCompared) {
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
  // Where each run's values of each bucket go: behind those of the runs before it.
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
    // Buckets of one run after another would leave the full ones in the middle to one thread.
    for (std::size_t b = static_cast<std::size_t>(r); b < kLargeBuckets; b += kRuns) {
      const std::size_t begin = begins[b];
      const std::size_t count = begins[b + 1] - begin;
      SortSmall(scratch.subspan(begin, count), values.subspan(begin, count), small_ends);
      std::copy_n(scratch.begin() + begin, count, values.begin() + begin);
    }
  });
}

}  // namespace motiondb::core
