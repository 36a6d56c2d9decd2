// Parallel loops on the caller's threads. Core starts no threads.
#pragma once

#include <functional>

namespace motiondb::core {

// Runs body(0) ... body(count - 1), in any order and on any threads, and returns when all are done.
// Results must not depend on the order: each index writes its own result, and results are combined
// in order of index.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

// Runs on the calling thread only.
inline void RunSerially(int count, const std::function<void(int)>& body) {
  for (int i = 0; i < count; ++i) body(i);
}

}  // namespace motiondb::core
