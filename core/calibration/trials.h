// Many trials side by side, which can be stopped between any few of them.
#pragma once

#include <algorithm>
#include <functional>
#include <string_view>

#include "absl/status/status.h"
#include "core/model/model_builder.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Runs trial(0) ... trial(count - 1), each writing its result to a place of its own. CANCELLED if
// `progress` returns false.
inline absl::Status RunTrials(int count, std::string_view stage, const ParallelFor& parallel,
                              const BuildProgress& progress,
                              const std::function<void(int)>& trial) {
  constexpr int kAtOnce = 8;
  for (int begin = 0; begin < count; begin += kAtOnce) {
    if (progress && !progress(static_cast<double>(begin) / count, stage)) {
      return absl::CancelledError("the calibration was cancelled");
    }
    parallel(std::min(kAtOnce, count - begin), [&](int i) { trial(begin + i); });
  }
  return absl::OkStatus();
}

}  // namespace motiondb::core
