#include "server/rpc/call.h"

#include <exception>
#include <new>
#include <utility>

#include "core/motion/error.h"
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

UnaryReactor::UnaryReactor(ServiceContext& host, const grpc::CallbackServerContext& context,
                           const Method& method, const google::protobuf::Message& request,
                           const google::protobuf::Message& response, Handler handler)
    : parking_(host.engine.workers()),
      entry_(host, context, method, [this] { parking_.Stop(); }),
      call_{host.engine,  entry_.cancelled(), entry_.deadline(), entry_,
            host.monitor, parking_,           host.streams,      host.others.get()},
      response_(response),
      handler_(std::move(handler)) {
  if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
    End(std::move(admission));
    return;
  }
  entry_.SetRequestSize(request.ByteSizeLong());
  entry_.Begin(request, [this](grpc::Status checked) { Work(std::move(checked)); });
}

void UnaryReactor::Work(grpc::Status checked) {
  if (!checked.ok()) return End(std::move(checked));
  const LogFields fields{{"request_id", entry_.request_id()}};
  bool is_heavy = false;
  bool waits = false;
  std::size_t bytes = 0;
  parking_.BeginStep();
  grpc::Status answered = RunHandler(call_.cancelled, [&]() -> absl::Status {
    absl::Status handled = handler_(call_);
    is_heavy = IsHeavyWork(handled);
    waits = IsAwaitingChange(handled);
    if (!handled.ok()) return handled;
    bytes = response_.ByteSizeLong();
    MOTIONDB_RETURN_IF_ERROR(entry_.ReserveWork(0));
    return entry_.ReserveResponse(response_, bytes);
  });
  if (waits && parking_.stopped()) return End(StoppingStatus());
  if (waits) {
    return parking_.Park(call_.deadline,
                         [this] { entry_.Post([this] { Work(ToGrpcStatus(entry_.Recheck())); }); });
  }
  if (!is_heavy) return End(std::move(answered), bytes);
  entry_.BeginHeavy([this](grpc::Status entered) { Work(std::move(entered)); });
}

void UnaryReactor::End(grpc::Status status, std::size_t answer_bytes) {
  Finish(entry_.End(std::move(status), answer_bytes));
}

}  // namespace motiondb::server
