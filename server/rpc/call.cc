#include "server/rpc/call.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <new>

#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

bool IsOwnFault(absl::StatusCode code) {
  return code == absl::StatusCode::kInternal || code == absl::StatusCode::kUnknown ||
         code == absl::StatusCode::kDataLoss;
}

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
  const absl::Status status = WithoutExceptions(handler);
  if (IsOwnFault(status.code())) spdlog::error("a call failed: {}", status.ToString());
  return ToGrpcStatus(status);
}

}  // namespace motiondb::server
