// The deadline of a query in a server. A query that runs much longer is a finding: libFuzzer stops
// it.
#pragma once

#include <chrono>

#include "core/motion/execution.h"
#include "tests/fuzz/server/answer_properties.h"

namespace motiondb::tests {

inline core::Cancelled AfterSeconds(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  return [end] { return Clock::now() >= end; };
}

constexpr double kQuerySeconds = 5;

// CheckRefusalContract, for a query that may have been cancelled.
inline void CheckRefusalOrCancelled(const absl::Status& status) {
  if (!absl::IsCancelled(status)) CheckRefusalContract(status);
}

}  // namespace motiondb::tests
