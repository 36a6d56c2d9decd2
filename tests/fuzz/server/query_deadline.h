// The deadline that a query has at a server, so that one which goes on after it is a finding: of
// libFuzzer's, which ends what takes far longer.
#pragma once

#include <chrono>

#include "core/motion/cancellation.h"
#include "tests/fuzz/server/answer_properties.h"

namespace motiondb::tests {

inline core::Cancelled AfterSeconds(double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  return [end] { return Clock::now() >= end; };
}

constexpr double kQuerySeconds = 5;

// HoldsRefusal, of a query that may have been ended.
inline void HoldsEnd(const absl::Status& status) {
  if (!absl::IsCancelled(status)) HoldsRefusal(status);
}

}  // namespace motiondb::tests
