#include "server/rpc/call.h"

#include <exception>
#include <new>

#include "server/engine/work/memory_reserve.h"
#include "server/translate/status_mapping.h"
#include "storage/thread_scopes.h"

namespace motiondb::server {

namespace {

absl::Status WithoutExceptions(const std::function<absl::Status()>& handler) {
  try {
    const AllocationsMayFail scope;
    return handler();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        "out of memory for this call: send less per call, or retry later");
  } catch (const std::exception& error) {
    return absl::InternalError(error.what());
  }
}

}  // namespace

grpc::Status RunHandler(const core::Cancelled& cancelled,
                        const std::function<absl::Status()>& handler) {
  if (cancelled()) return {grpc::StatusCode::CANCELLED, "the call was cancelled"};
  if (const absl::Status memory = RefillMemoryReserve(); !memory.ok()) return ToGrpcStatus(memory);
  const storage::ReadScope scope(cancelled);
  return ToGrpcStatus(WithoutExceptions(handler));
}

}  // namespace motiondb::server
