// A loop that several threads of a pool share. Thread-safe.
#pragma once

#include <functional>

namespace motiondb::server {

// Runs body(0) ... body(count - 1) on the calling thread and on up to `helpers` others, to which
// `post` hands a piece of work; returns when all are done. Free of deadlock: a helper that comes
// late, or never, leaves the work to the others. The first exception of a body is thrown here,
// after the rest have ended.
void RunSharedLoop(int count, const std::function<void(int)>& body, int helpers,
                   const std::function<void(std::function<void()>)>& post);

}  // namespace motiondb::server
