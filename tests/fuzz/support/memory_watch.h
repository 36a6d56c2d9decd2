// Counts the memory that the watching thread takes, through the address sanitizer's hooks.
#pragma once

#include <cstddef>

namespace motiondb::tests {

// From its making to its end: takes of this thread alone, so that threads of an engine do not
// count. One at a time.
class MemoryWatch {
 public:
  MemoryWatch();
  ~MemoryWatch();
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

  // Aborts if at any time since the start more than `base` bytes and `factor` times the input were
  // held.
  void HoldsProportional(std::size_t input_bytes, std::size_t base, std::size_t factor) const;
};

}  // namespace motiondb::tests
