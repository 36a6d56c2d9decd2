// Server-streaming calls. Each message is made on a request thread after the previous one was
// accepted, so a slow client needs no more memory. An idle client is disconnected. A source that
// has no message yet waits for a change (parking.h).
#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <functional>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/call.h"
#include "server/rpc/parking.h"

namespace motiondb::server {

// Makes the next message; returns false at the end. AwaitsChange: there is none yet, and it has
// subscribed to a change by Call::parking. Owns its data. Called by one thread at a time.
template <typename Response>
using MessageSource = std::function<absl::StatusOr<bool>(Response&)>;

// Owned by gRPC: deletes itself when the call is over.
template <typename Request, typename Response>
class StreamReactor : public grpc::ServerWriteReactor<Response> {
 public:
  // `open`: checks the request and returns the MessageSource.
  using Open = std::function<absl::StatusOr<MessageSource<Response>>(const Call&, const Request&)>;

  // gRPC keeps `request` until the call is finished.
  StreamReactor(ServiceContext& host, grpc::CallbackServerContext* context, const Request* request,
                Open open)
      : parking_(host.engine.workers()),
        entry_(host, *context, MethodOf<Request>(), [this] { parking_.Stop(); }),
        call_{host.engine,  entry_.cancelled(), entry_.deadline(), entry_,
              host.monitor, parking_,           host.streams,      host.others.get()},
        context_(*context),
        idle_timer_(host.engine.workers(), host.limits.options().idle_limit,
                    host.limits.options().idle_limit, [this] { OnIdle(); }) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      End(std::move(admission));
      return;
    }
    entry_.Begin(*request, [this, request, open = std::move(open)](grpc::Status checked) {
      Begin(open, *request, std::move(checked));
    });
  }

  void OnWriteDone(bool ok) override {
    writing_ = false;
    entry_.Post([this, ok] {
      // Posted, because the end may write an audit entry, and gRPC's threads must not block.
      if (!ok && idle_) return End(entry_.IdleStatus());
      if (!ok) return End({grpc::StatusCode::CANCELLED, "the client disconnected"});
      Step([this] { return Produce(); });
    });
  }
  void OnCancel() override { parking_.Wake(); }
  void OnDone() override { delete this; }

 private:
  // Opens the stream, once more as a heavy call if the work turns out to be heavy. The rest of such
  // a call is light.
  void Begin(const Open& open, const Request& request, grpc::Status checked,
             bool as_heavy = false) {
    if (!checked.ok()) return End(std::move(checked));
    bool is_heavy = false;
    parking_.BeginStep();
    grpc::Status begun = RunHandler(call_.cancelled, [&]() -> absl::Status {
      auto opened = open(call_, request);
      is_heavy = IsHeavyWork(opened.status());
      waits_ = IsAwaitingChange(opened.status());
      if (!opened.ok()) return opened.status();
      next_ = *std::move(opened);
      return Produce();
    });
    if (as_heavy) entry_.EndHeavy();
    if (next_ == nullptr && waits_) {
      if (parking_.stopped()) return End(StoppingStatus());
      return parking_.Park(entry_.deadline(), [this, open, &request] {
        entry_.Post(
            [this, open, &request] { Begin(open, request, ToGrpcStatus(entry_.Recheck())); });
      });
    }
    if (!is_heavy) return Continue(std::move(begun));
    entry_.BeginHeavy([this, open, &request](grpc::Status entered) {
      Begin(open, request, std::move(entered), true);
    });
  }

  absl::Status Produce() {
    MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
    message_.Clear();
    parking_.BeginStep();
    auto made = next_(message_);
    waits_ = IsAwaitingChange(made.status());
    if (waits_) return absl::OkStatus();
    if (!made.ok()) return made.status();
    ended_ = !*made;
    return absl::OkStatus();
  }

  void Step(const std::function<absl::Status()>& step) {
    Continue(RunHandler(call_.cancelled, step));
  }

  void Continue(grpc::Status status) {
    if (!status.ok() || ended_) return End(std::move(status));
    if (waits_ && parking_.stopped()) return End(StoppingStatus());
    if (waits_) {
      return parking_.Park(entry_.deadline(),
                           [this] { entry_.Post([this] { Step([this] { return Produce(); }); }); });
    }
    idle_timer_.Restart();
    writing_ = true;
    this->StartWrite(&message_);
  }

  // Cancels, because a status would be queued behind the message that the client does not read.
  void OnIdle() {
    if (!writing_) return;
    idle_ = true;
    context_.TryCancel();
  }

  void End(grpc::Status status) { this->Finish(entry_.End(std::move(status))); }

  Parking parking_;
  CallContext entry_;
  const Call call_;
  MessageSource<Response> next_;
  Response message_;
  bool ended_ = false;
  bool waits_ = false;
  grpc::CallbackServerContext& context_;
  std::atomic<bool> writing_ = false;  // until the flow-control window has room for the message
  std::atomic<bool> idle_ = false;
  IdleTimer idle_timer_;  // last: its callback uses the members above
};

}  // namespace motiondb::server
