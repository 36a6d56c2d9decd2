#include "tests/fuzz/support/memory_watch.h"

#include <sanitizer/allocator_interface.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

namespace motiondb::tests {
namespace {

thread_local bool watching = false;
thread_local std::int64_t held = 0;
thread_local std::int64_t peak = 0;

void OnMalloc(const volatile void*, std::size_t size) {
  if (!watching) return;
  held += static_cast<std::int64_t>(size);
  peak = std::max(peak, held);
}

void OnFree(const volatile void* memory) {
  if (!watching || memory == nullptr) return;
  held -=
      static_cast<std::int64_t>(__sanitizer_get_allocated_size(const_cast<const void*>(memory)));
}

}  // namespace

MemoryWatch::MemoryWatch() {
  static const int kInstalled = __sanitizer_install_malloc_and_free_hooks(OnMalloc, OnFree);
  (void)kInstalled;
  held = 0;
  peak = 0;
  watching = true;
}

MemoryWatch::~MemoryWatch() { watching = false; }

void MemoryWatch::CheckProportional(std::size_t input_bytes, std::size_t base,
                                    std::size_t factor) const {
  const std::size_t limit = base + factor * input_bytes;
  if (peak <= static_cast<std::int64_t>(limit)) return;
  std::fprintf(stderr,
               "contract violated: %zu bytes of input needed %lld bytes of memory, limit %zu\n",
               input_bytes, static_cast<long long>(peak), limit);
  std::abort();
}

}  // namespace motiondb::tests
