#include "server/rpc/run_handler.h"

#include <exception>
#include <new>

#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

absl::Status WithoutExceptions(const std::function<absl::Status()>& handler) {
  try {
    return handler();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("not enough memory to answer");
  } catch (const std::exception& error) {
    return absl::InternalError(error.what());
  }
}

}  // namespace

grpc::Status RunHandler(const core::Cancelled& cancelled,
                        const std::function<absl::Status()>& handler) {
  if (cancelled()) return {grpc::StatusCode::CANCELLED, "nobody waits for the answer"};
  return ToGrpcStatus(WithoutExceptions(handler));
}

}  // namespace motiondb::server
