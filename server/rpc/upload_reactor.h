// How a call with a stream of requests and one response is answered: each message is taken before
// the next is asked for, so a fast client costs no more memory than a slow one, and a client that
// is silent for too long is sent away.
#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <utility>

#include "core/motion/error.h"
#include "server/rpc/call.h"
#include "server/rpc/silence_limit.h"

namespace motiondb::server {

// Where messages after the first are taken: on a request thread, or at once on gRPC's own, for what
// only copies them.
enum class Taking { kOnRequestThread, kAtOnce };

// Owned by gRPC: deletes itself when the call is over.
template <typename Request>
class UploadReactor : public grpc::ServerReadReactor<Request> {
 public:
  void OnReadDone(bool ok) final {
    if (!reading_.exchange(false)) return;  // the call has ended meanwhile
    // A stream without any message is checked at its end.
    if (!std::exchange(begun_, true)) {
      return entry_.Begin(message_, [this, ok](grpc::Status checked) {
        checked.ok() ? Step(ok) : End(std::move(checked));
      });
    }
    if (ok && taking_ == Taking::kAtOnce) return TakeAtOnce();
    entry_.Post([this, ok] { Step(ok); });
  }
  void OnDone() final { delete this; }

 protected:
  UploadReactor(CallHost& host, grpc::CallbackServerContext& context, Taking taking)
      : entry_(host, context, MethodOf<Request>()),
        taking_(taking),
        silence_(host.engine.workers(), host.limits.first_silence(),
                 host.limits.options().longest_silence, [this] { EndSilence(); }) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      End(std::move(admission));
      return;
    }
    StartReading();
  }
  ~UploadReactor() override = default;

  // Takes a message from a caller who may send it; the first on a request thread.
  virtual absl::Status Take(Request& message) = 0;
  // All was sent, perhaps nothing: fills the response. On a request thread.
  virtual absl::Status Answer() = 0;

  CallEntry& entry() { return entry_; }

 private:
  void Read() {
    silence_.Restart();
    StartReading();
  }
  void StartReading() {
    reading_ = true;
    this->StartRead(&message_);
  }

  // What was read, or the end if it is not `ok`, comes to this.
  grpc::Status Taken(bool ok) {
    return RunHandler(entry_.cancelled(), [this, ok]() -> absl::Status {
      const LogFields fields{{"request_id", entry_.request_id()}};
      MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
      if (ok) MOTIONDB_RETURN_IF_ERROR(entry_.ReserveRequest(message_));
      return ok ? Take(message_) : Answer();
    });
  }

  void Step(bool ok) {
    grpc::Status status = Taken(ok);
    if (!ok || !status.ok()) return End(std::move(status));
    Read();
  }

  void TakeAtOnce() {
    const grpc::Status status = Taken(true);
    if (status.ok()) return Read();
    // The end has to be recorded, and gRPC's threads write nothing.
    entry_.Post([this, status] { End(status); });
  }

  // What was sent so far is kept, and a rebuild may be waiting for the rest.
  void EndSilence() {
    if (reading_.exchange(false)) End(entry_.Silent());
  }

  void End(grpc::Status status) { this->Finish(entry_.End(std::move(status))); }

  CallEntry entry_;
  const Taking taking_;
  Request message_;
  bool begun_ = false;                 // a message has come
  std::atomic<bool> reading_ = false;  // a read is under way, and the call has not ended
  SilenceLimit silence_;               // last: it calls what is above
};

}  // namespace motiondb::server
