// Runs work of a build or an update of a model, and converts exceptions to a status.
#pragma once

#include <exception>
#include <new>

#include "absl/status/status.h"
#include "server/engine/work/memory_reserve.h"
#include "server/engine/work/shared_loop.h"

namespace motiondb::server {

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
