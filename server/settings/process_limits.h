// Limits of the operating system for this process.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace motiondb::server {

// Checks the limits before a start. Returns RESOURCE_EXHAUSTED with the limit and the required
// value if the process cannot open enough files (RLIMIT_NOFILE) or cannot start `work_threads` plus
// the threads of its libraries (RLIMIT_NPROC, or address space for the stacks). Starts and joins
// that many threads.
absl::Status CheckProcessLimits(int work_threads);

// If the address space is limited (RLIMIT_AS), limits malloc to two arenas. Each arena reserves 64
// MiB, and the default is eight arenas for each core. Call this before threads start.
void LimitMallocArenas();

// Returns the memory that this process may use, in bytes: the minimum of the machine's memory and
// the limits of the process's control groups (versions 1 and 2) and their ancestors. `root` is the
// directory of /proc and /sys.
std::int64_t MemoryLimit(const std::string& root = "");

}  // namespace motiondb::server
