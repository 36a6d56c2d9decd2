// Limits of a process that reads a file from a stranger.
#pragma once

#include <cstdint>

#include "absl/status/status.h"

namespace motiondb::importer {

struct SandboxLimits {
  std::int64_t memory_bytes = std::int64_t{2} << 30;  // address space
  int cpu_seconds = 30;
  // Of the result: an inspected file has at most 2,000 joints or 65,535 markers.
  std::int64_t result_bytes = std::int64_t{32} << 20;
};

// The only file that a process in the sandbox can write, besides standard error.
inline constexpr int kOutputDescriptor = 3;

// Restricts the calling process for the rest of its life: memory, processor time, no file but
// kOutputDescriptor and standard error, no new executable memory, and only the system calls that
// computing needs. A forbidden call kills the process (SIGSYS). Too much processor time ends it by
// SIGXCPU. The caller must be single-threaded. INTERNAL if the kernel refuses.
absl::Status EnterSandbox(const SandboxLimits& limits);

}  // namespace motiondb::importer
