#include "tests/bench/window_search.h"

#include <dlfcn.h>
#include <faiss/utils/distances.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

namespace motiondb::tests {
namespace {

constexpr int kBlock = 4096;    // start frames of a block: their distances stay in the cache
constexpr int kPartBlocks = 8;  // blocks per work item

// The BLAS libraries start their own threads unless disabled, each by its own call.
void KeepBlasToOneThread() {
  static const bool done = [] {
    using SetThreads = void (*)(int);
    const auto set = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (set != nullptr) set(1);
    return true;
  }();
  static_cast<void>(done);
}

// Returns the nearest of the windows that begin in [begin, end).
NearestWindow SearchPart(const core::FrameMatrix& frames, const std::vector<core::ModelClip>& clips,
                         const core::FrameMatrix& window, int begin, int end) {
  const auto length = static_cast<int>(window.rows());
  NearestWindow nearest{.distance = INFINITY};
  auto clip = std::partition_point(clips.begin(), clips.end(), [&](const core::ModelClip& c) {
    return c.first_frame + c.frame_count <= begin;
  });
  core::FrameMatrix distances(length, kBlock + length - 1);
  Eigen::RowVectorXf sums(kBlock);
  for (int first = begin; first < end; first += kBlock) {
    const int starts = std::min(kBlock, end - first);
    faiss::pairwise_L2sqr(frames.cols(), length, window.data(), starts + length - 1,
                          frames.row(first).data(), distances.data(), -1, -1, distances.cols());
    sums.head(starts) = distances.row(0).head(starts);
    for (int k = 1; k < length; ++k) sums.head(starts) += distances.row(k).segment(k, starts);
    // The part of each clip in the block.
    for (; clip != clips.end(); ++clip) {
      const int clip_end = clip->first_frame + clip->frame_count;
      const int from = std::max(clip->first_frame - first, 0);
      const int to = std::min(clip_end - length + 1 - first, starts);
      if (from < to) {
        Eigen::Index at = 0;
        const float minimum = sums.segment(from, to - from).minCoeff(&at);
        if (minimum < nearest.distance) {
          nearest = {static_cast<int>(clip - clips.begin()), first + from + static_cast<int>(at),
                     minimum};
        }
      }
      if (clip_end > first + starts) break;  // the clip continues in the next block
    }
  }
  return nearest;
}

}  // namespace

NearestWindow FindNearestWindow(const core::FrameMatrix& frames,
                                const std::vector<core::ModelClip>& clips,
                                const core::FrameMatrix& window,
                                const core::ParallelFor& parallel) {
  KeepBlasToOneThread();
  const auto starts = static_cast<int>(frames.rows() - window.rows()) + 1;
  constexpr int kPart = kBlock * kPartBlocks;
  std::vector<NearestWindow> nearest(std::max(0, (starts + kPart - 1) / kPart));
  parallel(static_cast<int>(nearest.size()), [&](int part) {
    omp_set_num_threads(1);  // applies to regions opened by this thread
    nearest[part] =
        SearchPart(frames, clips, window, part * kPart, std::min((part + 1) * kPart, starts));
  });
  const auto best = std::min_element(
      nearest.begin(), nearest.end(),
      [](const NearestWindow& a, const NearestWindow& b) { return a.distance < b.distance; });
  return best == nearest.end() ? NearestWindow{.distance = INFINITY} : *best;
}

}  // namespace motiondb::tests
