// What the operating system lets the process have, checked before anything is made with it.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace motiondb::server {

// RESOURCE_EXHAUSTED, naming the limit and what is needed, if the process may not open enough files
// (RLIMIT_NOFILE) or cannot run the threads of the server: `work_threads` and those of its
// libraries (RLIMIT_NPROC, or address space for their stacks). Starts and ends that many threads.
absl::Status CheckProcessLimits(int work_threads);

// Where the address space is limited (RLIMIT_AS): has malloc share two arenas among all threads.
// Each reserves 64 MiB, and by default there are eight for each core. To be called before threads
// are started.
void SaveAddressSpace();

// How much memory this process may use, by the machine and by its control groups.

// In bytes: the least of the machine's memory and the limits of the process's control groups
// (versions 1 and 2) and those above them. `root` is where /proc and /sys are.
std::int64_t MemoryLimit(const std::string& root = "");

}  // namespace motiondb::server
