// What the work for a call may use, and why it may run again.
//
// Light work ends within moments. If it turns out to be heavy, it returns HeavyWork, and the call
// runs it again from its beginning as heavy work (CallContext::BeginHeavy). Work that cannot go on
// before a change of the database returns AwaitsChange and runs again after it. It has changed
// nothing before it returns one of them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include "absl/status/status.h"
#include "core/motion/execution.h"

namespace motiondb::server {

class ChangeSignal;

// Light work only, or all work within the limits.
enum class AllowedWork { kLightWork, kAllWork };

// Limits of the work for a call: amount, time and memory.
struct WorkOptions {
  AllowedWork allowed = AllowedWork::kAllWork;
  core::Cancelled cancelled;
  // Sets the memory reservation (bytes) for the rest of the work; replaces the previous one. Empty:
  // no limit.
  std::function<absl::Status(std::int64_t)> reserve = {};
  // Deadline of the caller; max() if the caller set none.
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  // Runs the work again after the next change that `signal` reports, if the work then returns
  // AwaitsChange. Empty: the caller cannot wait.
  std::function<void(ChangeSignal& signal)> wake_on = {};

  // RESOURCE_EXHAUSTED.
  absl::Status Reserve(std::int64_t bytes) const {
    return reserve ? reserve(bytes) : absl::OkStatus();
  }
};

// Returns the status of heavy work where only light work is allowed.
absl::Status HeavyWork();
bool IsHeavyWork(const absl::Status& status);

// Returns the status of work that cannot go on before a database changes; see WorkOptions::wake_on.
absl::Status AwaitsChange();
bool IsAwaitingChange(const absl::Status& status);

}  // namespace motiondb::server
