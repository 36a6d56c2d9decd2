// How long a read of a store waits for its turn: no longer than the caller wants the answer.
#pragma once

#include <utility>

#include "core/motion/cancellation.h"

namespace motiondb::storage {

// While it lives, reads of this thread that wait for their turn give up with CANCELLED soon after
// `cancelled` says so. An empty function: they wait as long as it takes, as without a scope. Scopes
// nest. The function must outlive the scope.
class ReadScope {
 public:
  explicit ReadScope(const core::Cancelled& cancelled)
      : outer_(std::exchange(current_, &cancelled)) {}
  ReadScope(const ReadScope&) = delete;
  ReadScope& operator=(const ReadScope&) = delete;
  ~ReadScope() { current_ = outer_; }

  // Of this thread; empty without a scope.
  static core::Cancelled cancelled() { return current_ == nullptr ? core::Cancelled() : *current_; }

 private:
  static inline thread_local const core::Cancelled* current_ = nullptr;
  const core::Cancelled* const outer_;
};

}  // namespace motiondb::storage
