#include "core/tree/wide_vectors.h"

#include <atomic>

namespace motiondb::core {
namespace {

bool HasWideVectors() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2");
#else
  return false;
#endif
}

std::atomic<bool>& Chosen() {
  static std::atomic<bool> chosen = HasWideVectors();
  return chosen;
}

}  // namespace

bool WideVectors() { return Chosen().load(std::memory_order_relaxed); }

bool UseWideVectors(bool wide) {
  Chosen() = wide && HasWideVectors();
  return HasWideVectors();
}

}  // namespace motiondb::core
