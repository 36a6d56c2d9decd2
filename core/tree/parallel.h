// Threads that a caller lends. Core starts none of its own.
#pragma once

#include <functional>

namespace motiondb::core {

// Runs body(0) ... body(count - 1), in any order and on any threads, and returns when all are done.
// Results must not depend on the order: every algorithm here writes each index's result to a place
// of its own and combines them in order of index.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

// On the calling thread alone.
inline void Serially(int count, const std::function<void(int)>& body) {
  for (int i = 0; i < count; ++i) body(i);
}

}  // namespace motiondb::core
