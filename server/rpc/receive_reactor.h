// Client-streaming calls. Each message is processed before the next one is read, so a fast client
// needs no more memory. An idle client gets DEADLINE_EXCEEDED.
#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <utility>

#include "core/motion/error.h"
#include "server/rpc/call.h"
#include "server/rpc/parking.h"

namespace motiondb::server {

// Where messages after the first are processed: on a request thread, or directly on gRPC's thread
// if they are only copied.
enum class ReceiveThread { kOnRequestThread, kGrpcThread };

// Owned by gRPC: deletes itself when the call is over.
template <typename Request>
class ReceiveReactor : public grpc::ServerReadReactor<Request> {
 public:
  void OnReadDone(bool ok) final {
    if (!reading_.exchange(false)) return;  // the call has ended
    // A stream without any message is checked at its end.
    if (!std::exchange(started_, true)) {
      return entry_.Begin(message_, [this, ok](grpc::Status checked) {
        checked.ok() ? Step(ok) : End(std::move(checked));
      });
    }
    if (ok && taking_ == ReceiveThread::kGrpcThread) return ProcessOnGrpcThread();
    if (!ok && NeedsImport()) return entry_.PostImport([this] { ImportThenAnswer(); });
    entry_.Post([this, ok] { Step(ok); });
  }
  void OnDone() final { delete this; }

 protected:
  ReceiveReactor(ServiceContext& host, grpc::CallbackServerContext& context, ReceiveThread taking)
      : entry_(host, context, MethodOf<Request>()),
        taking_(taking),
        idle_timer_(host.engine.workers(), host.limits.first_message_limit(),
                    host.limits.options().idle_limit, [this] { OnIdle(); }) {
    if (grpc::Status admission = entry_.Admission(); !admission.ok()) {
      End(std::move(admission));
      return;
    }
    StartReading();
  }
  ~ReceiveReactor() override = default;

  // Processes a message of an authorized caller. The first one runs on a request thread.
  virtual absl::Status Take(Request& message) = 0;
  // Whether Import must run before Answer. After the last message.
  virtual bool NeedsImport() const { return false; }
  // Waits for another process, on a thread of Pool::kImports.
  virtual absl::Status Import() { return absl::OkStatus(); }
  // Fills the response after the last message; there may have been none. On a request thread.
  virtual absl::Status Answer() = 0;

  CallContext& entry() { return entry_; }

 private:
  void Read() {
    idle_timer_.Restart();
    StartReading();
  }
  void StartReading() {
    reading_ = true;
    this->StartRead(&message_);
  }

  // Processes the message that was read, or the end of the stream if not `ok`.
  grpc::Status Process(bool ok) {
    return RunHandler(entry_.cancelled(), [this, ok]() -> absl::Status {
      const LogFields fields{{"request_id", entry_.request_id()}};
      MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
      if (ok) MOTIONDB_RETURN_IF_ERROR(entry_.ReserveRequest(message_));
      return ok ? Take(message_) : Answer();
    });
  }

  void Step(bool ok) {
    grpc::Status status = Process(ok);
    if (!ok || !status.ok()) return End(std::move(status));
    Read();
  }

  void ProcessOnGrpcThread() {
    const grpc::Status status = Process(true);
    if (status.ok()) return Read();
    // Posted, because the end writes an audit entry, and gRPC's threads must not block.
    entry_.Post([this, status] { End(status); });
  }

  void ImportThenAnswer() {
    const grpc::Status status = RunHandler(entry_.cancelled(), [this]() -> absl::Status {
      const LogFields fields{{"request_id", entry_.request_id()}};
      MOTIONDB_RETURN_IF_ERROR(entry_.Recheck());
      return Import();
    });
    entry_.Post([this, status] { status.ok() ? Step(false) : End(status); });
  }

  // Releases the memory of the upload; a build may also wait for the rest of it.
  void OnIdle() {
    if (reading_.exchange(false)) End(entry_.IdleStatus());
  }

  void End(grpc::Status status) { this->Finish(entry_.End(std::move(status))); }

  CallContext entry_;
  const ReceiveThread taking_;
  Request message_;
  bool started_ = false;               // the first message or the end has arrived
  std::atomic<bool> reading_ = false;  // a read is pending, and the call has not ended
  IdleTimer idle_timer_;               // last: its callback uses the members above
};

}  // namespace motiondb::server
