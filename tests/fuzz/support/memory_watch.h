// Measures the memory of the current thread with the address sanitizer's hooks.
#pragma once

#include <cstddef>

namespace motiondb::tests {

// Counts allocations of this thread from construction to destruction; an engine's threads do not
// count. Only one object at a time.
class MemoryWatch {
 public:
  MemoryWatch();
  ~MemoryWatch();
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

  // Aborts if the peak since the start exceeds `base` + `factor` * input_bytes.
  void CheckProportional(std::size_t input_bytes, std::size_t base, std::size_t factor) const;
};

}  // namespace motiondb::tests
