// Waiting for long work: the server's long poll, again and again until the work is done.
#include <fmt/format.h>

#include "client/connection.h"

namespace motiondb::client {
namespace {

using std::chrono::milliseconds;

// Time between two reports of progress.
constexpr milliseconds kPollTime{500};
// What a poll may take beyond that before the server counts as gone.
constexpr milliseconds kPollGrace{30'000};

}  // namespace

absl::StatusOr<v1::Operation> Client::WaitOperation(
    const std::string& name, const std::function<void(const v1::Operation&)>& on_progress,
    CallOptions options) const {
  const auto start = std::chrono::steady_clock::now();
  const milliseconds limit = options.timeout.value_or(kNoTimeout);
  while (true) {
    const auto waited =
        std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - start);
    if (waited >= limit) {
      return absl::DeadlineExceededError(fmt::format("{} was not done within {:g} s", name,
                                                     std::chrono::duration<double>(limit).count()));
    }
    const milliseconds poll = std::min(kPollTime, limit - waited);
    v1::WaitOperationRequest request;
    request.set_name(name);
    request.mutable_timeout()->set_seconds(poll.count() / 1000);
    request.mutable_timeout()->set_nanos(static_cast<int>(poll.count() % 1000) * 1'000'000);
    auto response =
        connection_->Call(*connection_->operations, &v1::OperationService::Stub::WaitOperation,
                          request, CallOptions{.timeout = poll + kPollGrace});
    if (!response.ok()) return response.status();
    if (on_progress) on_progress(response->operation());
    if (response->operation().done()) return std::move(*response->mutable_operation());
  }
}

absl::Status OperationStatus(const v1::Operation& operation) {
  switch (operation.state()) {
    case v1::OPERATION_STATE_SUCCEEDED:
      return absl::OkStatus();
    case v1::OPERATION_STATE_CANCELLED:
      return absl::CancelledError(fmt::format("{} was cancelled", operation.name()));
    case v1::OPERATION_STATE_FAILED: {
      const int code = operation.error().code();
      return absl::Status(
          code == 0 ? absl::StatusCode::kUnknown : static_cast<absl::StatusCode>(code),
          fmt::format("{} failed: {}", operation.name(), operation.error().message()));
    }
    default:
      return absl::FailedPreconditionError(fmt::format("{} is not done", operation.name()));
  }
}

}  // namespace motiondb::client
