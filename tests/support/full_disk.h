// A disk that has no room when a test says so.
#pragma once

#include <atomic>

#include "absl/status/status.h"

namespace motiondb::tests {

// Outlives the store that writes to it. Thread-safe.
class FullDisk {
 public:
  enum class Lacks { kNothing, kRoomForOperations, kRoom };
  void Set(Lacks lacks) { lacks_ = lacks; }

  // On the store's side: of an operation, and of anything else.
  absl::Status WriteOperation() const { return Write(lacks_ != Lacks::kNothing); }
  absl::Status Write() const { return Write(lacks_ == Lacks::kRoom); }

 private:
  static absl::Status Write(bool is_full) {
    return is_full ? absl::ResourceExhaustedError("database or disk is full") : absl::OkStatus();
  }

  std::atomic<Lacks> lacks_ = Lacks::kNothing;
};

}  // namespace motiondb::tests
