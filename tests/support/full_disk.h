// A simulated disk that is full when a test chooses.
#pragma once

#include <atomic>

#include "absl/status/status.h"

namespace motiondb::tests {

// Must outlive the store that writes to it. Thread-safe.
class SimulatedDisk {
 public:
  enum class Lacks { kNothing, kRoomForOperations, kRoom };
  void Set(Lacks lacks) { lacks_ = lacks; }

  // Called by the store before it writes an operation, or anything else.
  absl::Status WriteOperation() const { return Write(lacks_ != Lacks::kNothing); }
  absl::Status Write() const { return Write(lacks_ == Lacks::kRoom); }

 private:
  static absl::Status Write(bool is_full) {
    return is_full ? absl::ResourceExhaustedError("database or disk is full") : absl::OkStatus();
  }

  std::atomic<Lacks> lacks_ = Lacks::kNothing;
};

}  // namespace motiondb::tests
