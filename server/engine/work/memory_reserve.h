// Behavior of the process when it is out of memory (operator new fails because of RLIMIT_AS or a
// lack of swap).
//
// Work that may fail runs in an AllocationsMayFail scope: std::bad_alloc is thrown, the caller
// catches it, and the call or build ends with RESOURCE_EXHAUSTED. Elsewhere an exception would end
// the process (gRPC parses messages on its own threads) or lose a call between two steps. There, a
// failed allocation takes memory from a reserve of address space. When the reserve is used up, it
// waits until other threads free memory.
#pragma once

#include "absl/status/status.h"
#include "storage/thread_scopes.h"

namespace motiondb::server {

using storage::AllocationsMayFail;

// Allocates the reserve and installs the new-handler, once per process. The reserve is never
// written: it uses address space but no memory. RESOURCE_EXHAUSTED.
absl::Status InstallMemoryReserve();

// Allocates the used part of the reserve again. RESOURCE_EXHAUSTED if there is not enough memory
// for the reserve and 16 MiB more: callers should then refuse new work.
absl::Status RefillMemoryReserve();

}  // namespace motiondb::server
