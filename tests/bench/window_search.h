// The peer of recognition: exact search of the stored window nearest to an observed one, by FAISS.
#pragma once

#include <vector>

#include "core/model/model.h"
#include "core/motion/matrix.h"
#include "core/tree/parallel.h"

namespace motiondb::tests {

struct NearestWindow {
  int clip = -1;        // -1 where every clip is shorter than the window
  int first_frame = 0;  // of the whole matrix
  float distance = 0;   // squared, summed over the window's frames
};

// Among all runs of as many frames as `window` has (frames x dimensions), within one clip, the one
// at the least sum of squared distances, frame by frame. Exact: nothing is left out or compressed.
// FAISS computes the distances of all stored frames to all frames of the window, a block of frames
// at a time (faiss::pairwise_L2sqr, one matrix product a block); windows are the sums along the
// diagonals. An index of whole windows would need the window's length times the memory.
//
// Blocks are shared between the threads lent; FAISS and its BLAS (OpenBLAS) are told to use no
// other for the rest of the process: threads of three kinds would hinder each other. O(frames *
// window * dimensions).
NearestWindow FindNearestWindow(const core::FrameMatrix& frames,
                                const std::vector<core::ModelClip>& clips,
                                const core::FrameMatrix& window, const core::ParallelFor& parallel);

}  // namespace motiondb::tests
