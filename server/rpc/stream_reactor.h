// How a call with a stream of responses is answered: each message is made on a request thread when
// the one before it was taken, so a slow client costs no more memory than a fast one.
#pragma once

#include <grpcpp/support/server_callback.h>

#include <functional>
#include <utility>

#include "absl/status/statusor.h"
#include "server/rpc/call.h"

namespace motiondb::server {

// Makes the next message; false where there is none. Holds what it needs; called by one thread at a
// time.
template <typename Response>
using NextMessage = std::function<absl::StatusOr<bool>(Response&)>;

// Owned by gRPC: deletes itself when the call is over.
template <typename Response>
class StreamReactor : public grpc::ServerWriteReactor<Response> {
 public:
  // `open` checks the request and returns what makes the messages.
  using Open = std::function<absl::StatusOr<NextMessage<Response>>(const Call&)>;

  StreamReactor(CallHost& host, grpc::CallbackServerContext* context, Open open)
      : ticket_(host.gate), call_{host.engine, CancellationOf(*context), context->deadline()} {
    if (!ticket_.admitted()) {
      this->Finish(Stopping());
      return;
    }
    call_.engine.workers().Post([this, open = std::move(open)] {
      Step([&]() -> absl::Status {
        auto opened = open(call_);
        if (!opened.ok()) return opened.status();
        next_ = *std::move(opened);
        return Produce();
      });
    });
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return this->Finish({grpc::StatusCode::CANCELLED, "the client went away"});
    call_.engine.workers().Post([this] { Step([this] { return Produce(); }); });
  }
  void OnDone() override { delete this; }

 private:
  absl::Status Produce() {
    message_.Clear();
    auto made = next_(message_);
    if (!made.ok()) return made.status();
    ended_ = !*made;
    return absl::OkStatus();
  }

  void Step(const std::function<absl::Status()>& step) {
    grpc::Status status = RunHandler(call_.cancelled, step);
    if (!status.ok() || ended_) return this->Finish(std::move(status));
    this->StartWrite(&message_);
  }

  const CallGate::Ticket ticket_;
  const Call call_;
  NextMessage<Response> next_;
  Response message_;
  bool ended_ = false;
};

}  // namespace motiondb::server
