// Marks work that may fail if memory runs out: it throws std::bad_alloc, and the caller gets a
// status. For all other work the process may keep a memory reserve
// (server/engine/work/memory_reserve.h).
#pragma once

namespace motiondb::storage {

// During its lifetime, failed allocations on its thread throw std::bad_alloc immediately. The code
// that creates it catches the exception. Scopes may nest.
class AllocationsMayFail {
 public:
  AllocationsMayFail() { ++depth_; }
  ~AllocationsMayFail() { --depth_; }
  AllocationsMayFail(const AllocationsMayFail&) = delete;
  AllocationsMayFail& operator=(const AllocationsMayFail&) = delete;

  // Returns whether a scope is active on this thread.
  static bool hold() { return depth_ > 0; }

 private:
  static inline thread_local int depth_ = 0;
};

}  // namespace motiondb::storage
