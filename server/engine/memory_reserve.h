// What happens where the process runs out of memory (operator new; RLIMIT_AS or no swap left).
//
// Work that can fail by itself runs in an AllocationsMayFail scope: std::bad_alloc is thrown, its
// caller catches it, and the call or the build ends with RESOURCE_EXHAUSTED. Everywhere else an
// exception would end the process (gRPC parses messages on threads of its own) or lose a call
// between two steps. There an allocation takes from a reserve of address space that was set aside
// at start, and waits for memory that others free once the reserve is used up. Thread-safe.
#pragma once

#include "absl/status/status.h"
#include "storage/allocations_may_fail.h"

namespace motiondb::server {

using storage::AllocationsMayFail;

// Sets the reserve aside and installs the handler of failed allocations, once per process. The
// reserve is never written to: it costs address space and no memory. RESOURCE_EXHAUSTED.
absl::Status InstallMemoryReserve();

// Sets the used part of the reserve aside again, if there is any. RESOURCE_EXHAUSTED if there is
// not enough memory for that and for 16 MiB beside it: new work should be refused.
absl::Status RefillMemoryReserve();

}  // namespace motiondb::server
