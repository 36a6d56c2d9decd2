// Which work can do without the memory that it asks for: it throws std::bad_alloc, and whoever
// asked for the work gets a status. The process may keep a reserve for all other work
// (server/engine/memory_reserve.h).
#pragma once

namespace motiondb::storage {

// On the thread that made it, while it lives: failed allocations throw std::bad_alloc immediately.
// May be nested. Whoever makes one catches the exception.
class AllocationsMayFail {
 public:
  AllocationsMayFail() { ++depth_; }
  ~AllocationsMayFail() { --depth_; }
  AllocationsMayFail(const AllocationsMayFail&) = delete;
  AllocationsMayFail& operator=(const AllocationsMayFail&) = delete;

  // Of this thread.
  static bool hold() { return depth_ > 0; }

 private:
  static inline thread_local int depth_ = 0;
};

}  // namespace motiondb::storage
