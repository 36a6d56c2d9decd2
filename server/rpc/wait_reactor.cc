#include "server/rpc/wait_reactor.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>

#include "core/motion/error.h"
#include "motiondb/v1/operation.pb.h"
#include "server/engine/operation_wait.h"
#include "server/rpc/call.h"
#include "server/translate/field_violation.h"
#include "server/translate/operation_message.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kDefaultTimeout{60'000};
constexpr milliseconds kLongestTimeout{24 * 3600 * 1000};

// The answer must be back before the deadline: a tenth of what is left, at most half a second, is
// kept for the way.
milliseconds UntilDeadline(std::chrono::system_clock::time_point deadline) {
  if (deadline == std::chrono::system_clock::time_point::max()) return kDefaultTimeout;
  const auto left =
      std::chrono::duration_cast<milliseconds>(deadline - std::chrono::system_clock::now());
  return std::clamp(left - std::min(left / 10, milliseconds(500)), milliseconds(0),
                    kLongestTimeout);
}

absl::StatusOr<milliseconds> TimeoutFrom(const v1::WaitOperationRequest& request,
                                         std::chrono::system_clock::time_point deadline) {
  const milliseconds until_deadline = UntilDeadline(deadline);
  if (!request.has_timeout()) return until_deadline;
  const auto& timeout = request.timeout();
  if (timeout.seconds() < 0 || timeout.nanos() < 0 || timeout.nanos() > 999'999'999) {
    return FieldViolation("timeout", "expected a duration that is not negative, got {} s {} ns",
                          timeout.seconds(), timeout.nanos());
  }
  const std::int64_t seconds = std::min<std::int64_t>(timeout.seconds(), 24 * 3600);
  const milliseconds given(seconds * 1000 + timeout.nanos() / 1'000'000);
  const bool has_deadline = deadline != std::chrono::system_clock::time_point::max();
  return has_deadline ? std::min(given, until_deadline) : std::min(given, kLongestTimeout);
}

class WaitReactor final : public grpc::ServerUnaryReactor {
 public:
  WaitReactor(CallHost& host, grpc::CallbackServerContext& context,
              const v1::WaitOperationRequest& request, v1::WaitOperationResponse& response)
      : entry_(host, context, MethodOf<v1::WaitOperationRequest>()), response_(response) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      Finish(entry_.End(std::move(admission)));
      return;
    }
    entry_.Begin(request, [this, &engine = host.engine, &context, &request](grpc::Status checked) {
      if (!checked.ok()) return Finish(entry_.End(std::move(checked)));
      Start(engine, request, context.deadline());
    });
  }

  void OnCancel() override {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    if (wait_ != nullptr) wait_->Stop();
  }
  void OnDone() override { delete this; }

 private:
  void Start(Engine& engine, const v1::WaitOperationRequest& request,
             std::chrono::system_clock::time_point deadline) {
    const auto id = ParseOperationName("name", request.name());
    const auto timeout = TimeoutFrom(request, deadline);
    const absl::Status valid = id.ok() ? timeout.status() : id.status();
    if (!valid.ok()) return Answer([&] { return valid; });
    const std::lock_guard lock(mutex_);
    wait_ = OperationWait::Start(engine.workers(), engine.operations(), *id, *timeout,
                                 [this](auto operation) { OnOperation(std::move(operation)); });
    if (cancelled_) wait_->Stop();
  }

  void OnOperation(const absl::StatusOr<storage::OperationRecord>& operation) {
    // Not before Start has let go of this, which the answer may delete.
    { const std::lock_guard lock(mutex_); }
    Answer([&]() -> absl::Status {
      MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
      if (!operation.ok()) return operation.status();
      SetOperation(*operation, *response_.mutable_operation());
      return absl::OkStatus();
    });
  }

  // The wait calls once, so the call is finished once.
  void Answer(const std::function<absl::Status()>& handler) {
    Finish(entry_.End(RunHandler([] { return false; }, handler)));
  }

  CallEntry entry_;
  v1::WaitOperationResponse& response_;
  std::mutex mutex_;
  bool cancelled_ = false;
  std::shared_ptr<OperationWait> wait_;
};

}  // namespace

grpc::ServerUnaryReactor* NewWaitReactor(CallHost& host, grpc::CallbackServerContext& context,
                                         const v1::WaitOperationRequest& request,
                                         v1::WaitOperationResponse& response) {
  return new WaitReactor(host, context, request, response);
}

}  // namespace motiondb::server
