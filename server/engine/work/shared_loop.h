// Parallel loops on a thread pool, their cancellation and their exceptions.
#pragma once

#include <exception>
#include <functional>
#include <new>
#include <utility>

#include "absl/status/status.h"
#include "core/motion/execution.h"
#include "server/engine/work/memory_reserve.h"

namespace motiondb::server {

// Runs body(0) ... body(count - 1) on the calling thread and on up to `helpers` others; `post`
// passes work to them. Returns when all are done. Free of deadlocks: if a helper comes late or
// never, the others do its work. The first exception of a body is rethrown here, after the rest
// have ended.
void RunSharedLoop(int count, const std::function<void(int)>& body, int helpers,
                   const std::function<void(std::function<void()>)>& post);

// Thrown by Stoppable loops.
class WorkStopped : public std::exception {
 public:
  const char* what() const noexcept override { return "the work was stopped"; }
};

// Returns a `parallel` that starts no more bodies once `stopped` returns true, and throws
// WorkStopped when the running ones have ended. All threads poll `stopped`.
inline core::ParallelFor Stoppable(core::ParallelFor parallel, core::Cancelled stopped) {
  return [parallel = std::move(parallel), stopped = std::move(stopped)](
             int count, const std::function<void(int)>& body) {
    parallel(count, [&](int i) {
      if (!stopped()) body(i);
    });
    if (stopped()) throw WorkStopped();
  };
}

// Runs work of a build or an update of a model, and converts exceptions to a status.
template <typename Result, typename Work>
Result WithoutExceptions(const Work& work) {
  Result result;
  try {
    const AllocationsMayFail scope;
    result = work();
  } catch (const WorkStopped&) {
    result = absl::CancelledError("stopped");
  } catch (const std::bad_alloc&) {
    result = absl::ResourceExhaustedError("not enough memory to build the model");
  } catch (const std::exception& error) {
    result = absl::InternalError(error.what());
  }
  return result;
}

}  // namespace motiondb::server
