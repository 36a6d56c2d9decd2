// Scopes of a thread: within them its reads can be cancelled, or its allocations may fail.
#pragma once

#include <utility>

#include "core/motion/execution.h"

namespace motiondb::storage {

// During its lifetime, reads of this thread that wait for a connection return CANCELLED within
// about 20 ms after `cancelled` returns true. With an empty function, or without a scope, they wait
// without limit. Scopes nest. The function must outlive the scope.
class ReadScope {
 public:
  explicit ReadScope(const core::Cancelled& cancelled)
      : outer_(std::exchange(current_, &cancelled)) {}
  ReadScope(const ReadScope&) = delete;
  ReadScope& operator=(const ReadScope&) = delete;
  ~ReadScope() { current_ = outer_; }

  // Returns the function of this thread's innermost scope; empty without a scope.
  static core::Cancelled cancelled() { return current_ == nullptr ? core::Cancelled() : *current_; }

 private:
  static inline thread_local const core::Cancelled* current_ = nullptr;
  const core::Cancelled* const outer_;
};

// Marks work that may fail if memory runs out: it throws std::bad_alloc, and the caller gets a
// status. For all other work the process may keep a memory reserve
// (server/engine/work/memory_reserve.h).
//
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

  // During its lifetime no scope is active: for a call of other work, which must not be lost.
  class Pause {
   public:
    Pause() : depth_before_(std::exchange(depth_, 0)) {}
    ~Pause() { depth_ = depth_before_; }
    Pause(const Pause&) = delete;
    Pause& operator=(const Pause&) = delete;

   private:
    const int depth_before_;
  };

 private:
  static inline thread_local int depth_ = 0;
};

}  // namespace motiondb::storage
