#include "server/engine/memory_reserve.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <new>
#include <thread>

namespace motiondb::server {
namespace {

// Four messages of the largest size that is accepted by default (--max-message-mib).
constexpr int kSliceCount = 4;
constexpr std::size_t kSliceBytes = std::size_t{16} << 20;
constexpr std::chrono::milliseconds kBetweenTries{10};
constexpr int kMostTries = 1000;  // 10 s

// Null: not set aside.
std::array<std::atomic<void*>, kSliceCount> slices;
std::atomic<bool> used{false};
std::atomic<bool> is_limited{false};  // RLIMIT_AS

void* SetAside() {
  void* const slice =
      mmap(nullptr, kSliceBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return slice == MAP_FAILED ? nullptr : slice;
}

bool ReleaseSlice() {
  used = true;
  for (std::atomic<void*>& slice : slices) {
    void* const taken = slice.exchange(nullptr);
    if (taken == nullptr) continue;
    munmap(taken, kSliceBytes);
    return true;
  }
  return false;
}

bool Fill() {
  for (std::atomic<void*>& slice : slices) {
    if (slice != nullptr) continue;
    void* const fresh = SetAside();
    if (fresh == nullptr) return false;
    void* expected = nullptr;
    if (!slice.compare_exchange_strong(expected, fresh)) munmap(fresh, kSliceBytes);
  }
  return true;
}

// Whether C code, which takes nothing from the reserve, would get memory: gRPC ends the process if
// it gets none.
bool HasHeadroom() {
  void* const slice = SetAside();
  if (slice != nullptr) munmap(slice, kSliceBytes);
  return slice != nullptr;
}

// Called by operator new where malloc fails; it tries again when this returns.
void OnFailedAllocation() {
  thread_local int tries = 0;
  if (AllocationsMayFail::hold()) throw std::bad_alloc();
  if (ReleaseSlice()) {
    tries = 0;
    return;
  }
  if (++tries > kMostTries) {
    tries = 0;
    throw std::bad_alloc();
  }
  std::this_thread::sleep_for(kBetweenTries);
}

}  // namespace

absl::Status InstallMemoryReserve() {
  if (!Fill()) {
    return core::WithReason("OUT_OF_MEMORY", absl::ResourceExhaustedError(
                                                 "not enough memory to start: 64 MiB of address "
                                                 "space cannot be set aside; raise the limit "
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
  return absl::ResourceExhaustedError(
      "the server is out of memory: try again later, or send less at a time");
}

}  // namespace motiondb::server
