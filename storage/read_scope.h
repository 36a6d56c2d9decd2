// Cancellation of reads that wait for a connection.
#pragma once

#include <utility>

#include "core/motion/cancellation.h"

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

}  // namespace motiondb::storage
