// The peer of recognition: FAISS's exact search of the stored window nearest to an observed one.
#pragma once

#include <vector>

#include "core/model/model.h"
#include "core/motion/execution.h"
#include "core/motion/matrix.h"

namespace motiondb::tests {

struct NearestWindow {
  int clip = -1;        // -1 if every clip is shorter than the window
  int first_frame = 0;  // of the whole matrix
  float distance = 0;   // squared, summed over the window's frames
};

// Returns the run of consecutive frames within one clip, of the length of `window` (frames x
// dimensions), with the minimum sum of squared distances to it. Exact. FAISS computes the distances
// of all stored frames to all frames of the window, one block of frames at a time
// (faiss::pairwise_L2sqr); windows are sums along the diagonals. An index of whole windows would
// need memory times the window's length. The given threads share the blocks. FAISS and its BLAS
// (OpenBLAS) are limited to one thread for the rest of the process. O(frames * window *
// dimensions).
NearestWindow FindNearestWindow(const core::FrameMatrix& frames,
                                const std::vector<core::ModelClip>& clips,
                                const core::FrameMatrix& window, const core::ParallelFor& parallel);

}  // namespace motiondb::tests
