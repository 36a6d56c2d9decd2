#include "server/engine/work/memory_reserve.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <new>
#include <thread>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

// Enough for four messages of the default maximum size (--max-message-mib).
constexpr int kSliceCount = 4;
constexpr std::size_t kSliceBytes = std::size_t{16} << 20;
constexpr std::chrono::milliseconds kRetryDelay{10};
constexpr int kMaxTries = 1000;  // 10 s

// Null: not reserved.
std::array<std::atomic<void*>, kSliceCount> slices;
std::atomic<bool> used{false};
std::atomic<bool> is_limited{false};  // RLIMIT_AS

void* ReserveSlice() {
  void* const slice =
      mmap(nullptr, kSliceBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return slice == MAP_FAILED ? nullptr : slice;
}

bool ReleaseSlice() {
  used = true;
  for (std::atomic<void*>& slice : slices) {
    void* const released = slice.exchange(nullptr);
    if (released == nullptr) continue;
    munmap(released, kSliceBytes);
    return true;
  }
  return false;
}

bool Fill() {
  for (std::atomic<void*>& slice : slices) {
    if (slice != nullptr) continue;
    void* const fresh = ReserveSlice();
    if (fresh == nullptr) return false;
    void* expected = nullptr;
    if (!slice.compare_exchange_strong(expected, fresh)) munmap(fresh, kSliceBytes);
  }
  return true;
}

// Returns whether C code could still allocate. It does not use the reserve, and gRPC ends the
// process if an allocation fails.
bool HasHeadroom() {
  void* const slice = ReserveSlice();
  if (slice != nullptr) munmap(slice, kSliceBytes);
  return slice != nullptr;
}

// Called by operator new if malloc fails; operator new retries when this returns.
void OnFailedAllocation() {
  thread_local int tries = 0;
  if (AllocationsMayFail::hold()) throw std::bad_alloc();
  if (ReleaseSlice()) {
    tries = 0;
    return;
  }
  if (++tries > kMaxTries) {
    tries = 0;
    throw std::bad_alloc();
  }
  std::this_thread::sleep_for(kRetryDelay);
}

}  // namespace

absl::Status InstallMemoryReserve() {
  if (!Fill()) {
    return core::WithReason(
        "OUT_OF_MEMORY",
        absl::ResourceExhaustedError(
            "not enough memory to start: cannot reserve 64 MiB of address space; raise the limit "
            "(ulimit -v, LimitAS)"));
  }
  rlimit limit{};
  is_limited = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  std::set_new_handler(OnFailedAllocation);
  return absl::OkStatus();
}

absl::Status RefillMemoryReserve() {
  if (used) {
    used = false;
    if (!Fill()) used = true;
  }
  if (!used && is_limited && !HasHeadroom()) ReleaseSlice();
  if (!used) return absl::OkStatus();
  return core::WithReason(
      "OUT_OF_MEMORY",
      absl::ResourceExhaustedError(
          "the server is out of memory: try again later, or send smaller requests"));
}

}  // namespace motiondb::server
