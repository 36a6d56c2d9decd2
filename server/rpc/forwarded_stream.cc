#include "server/rpc/forwarded_stream.h"

#include <grpcpp/client_context.h>
#include <grpcpp/support/client_callback.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "core/motion/error.h"
#include "server/translate/status_mapping.h"
#include "storage/mutex.h"

namespace motiondb::server {
namespace {

using storage::MutexLock;

constexpr std::chrono::seconds kMaxListTime{1};

// The call at the other server has the same caller and the same id.
void PassCaller(const Call& call, grpc::ClientContext& context) {
  const PeerCredentials caller = call.entry.credentials();
  if (!caller.authorization.empty()) context.AddMetadata("authorization", caller.authorization);
  context.AddMetadata("x-request-id", call.entry.request_id());
}

// A WatchStream call at another server. Reads a message when the one before was taken, so a slow
// client slows only this call down. Lives until gRPC has ended the call, which it does not before a
// read has failed, or Cancel was called and no read runs (AddHold).
class ForwardedWatch final : public grpc::ClientReadReactor<v1::WatchStreamResponse> {
 public:
  static std::shared_ptr<ForwardedWatch> Start(const Call& call, OtherServers::Stub owner,
                                               const v1::WatchStreamRequest& request) {
    std::shared_ptr<ForwardedWatch> watch(new ForwardedWatch(std::move(owner), request));
    watch->self_ = watch;
    PassCaller(call, watch->context_);
    watch->owner_->async()->WatchStream(&watch->context_, &watch->request_, watch.get());
    watch->AddHold();
    watch->StartRead(&watch->read_);
    watch->StartCall();
    return watch;
  }

  // Notified of each message and of the end.
  ChangeSignal& signal() { return *signal_; }
  // Next must not be called afterwards.
  void Cancel() {
    context_.TryCancel();
    bool has_hold = false;  // that no read removes
    {
      const MutexLock lock(mutex_);
      is_cancelled_ = true;
      has_hold = has_read_;
    }
    if (has_hold) RemoveHold();
  }

  // AwaitsChange if there is no message yet.
  absl::StatusOr<bool> Next(v1::WatchStreamResponse& message) {
    {
      const MutexLock lock(mutex_);
      if (!has_read_ && !ended_) return AwaitsChange();
      if (!has_read_) return ended_->ok() ? absl::StatusOr<bool>(false) : FromGrpcStatus(*ended_);
      message.Swap(&read_);
      has_read_ = false;
    }
    StartRead(&read_);
    return true;
  }

  void OnReadDone(bool ok) override {
    bool is_last = false;
    {
      const MutexLock lock(mutex_);
      is_last = !ok || is_cancelled_;
      has_read_ = !is_last;
    }
    if (is_last) return RemoveHold();  // OnDone follows
    signal_->Notify();
  }
  void OnDone(const grpc::Status& status) override {
    const auto self = std::move(self_);
    {
      const MutexLock lock(mutex_);
      ended_ = status;
    }
    signal_->Notify();
  }

 private:
  ForwardedWatch(OtherServers::Stub owner, v1::WatchStreamRequest request)
      : owner_(std::move(owner)), request_(std::move(request)) {}

  const OtherServers::Stub owner_;
  const v1::WatchStreamRequest request_;
  const std::shared_ptr<ChangeSignal> signal_ = std::make_shared<ChangeSignal>();
  grpc::ClientContext context_;
  std::shared_ptr<ForwardedWatch> self_;  // until OnDone
  v1::WatchStreamResponse read_;          // of gRPC until OnReadDone
  storage::Mutex mutex_;
  bool has_read_ ABSL_GUARDED_BY(mutex_) = false;  // a message that was not taken
  bool is_cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<grpc::Status> ended_ ABSL_GUARDED_BY(mutex_);
};

// Ends the call at the other server with the call here.
class WatchHandle {
 public:
  explicit WatchHandle(std::shared_ptr<ForwardedWatch> watch) : watch_(std::move(watch)) {}
  ~WatchHandle() { watch_->Cancel(); }
  WatchHandle(const WatchHandle&) = delete;
  WatchHandle& operator=(const WatchHandle&) = delete;

  ForwardedWatch& watch() const { return *watch_; }

 private:
  const std::shared_ptr<ForwardedWatch> watch_;
};

}  // namespace

std::vector<v1::ObservedStream> StreamsOfOthers(const Call& call, OtherServers& others,
                                                const v1::ListStreamsRequest& request) {
  struct Asked {
    grpc::ClientContext context;
    v1::ListStreamsResponse response;
  };
  std::vector<v1::ObservedStream> streams;
  const auto stubs = others.All();
  if (!stubs.ok()) return streams;  // as if none answered
  v1::ListStreamsRequest local = request;
  local.set_this_server(true);
  storage::Mutex mutex;
  storage::ConditionVariable answered;
  std::size_t missing = stubs->size();
  std::vector<std::unique_ptr<Asked>> all;
  for (const OtherServers::Stub& stub : *stubs) {
    Asked& asked = *all.emplace_back(std::make_unique<Asked>());
    PassCaller(call, asked.context);
    asked.context.set_deadline(std::chrono::system_clock::now() + kMaxListTime);
    stub->async()->ListStreams(
        &asked.context, &local, &asked.response, [&](const grpc::Status& status) {
          if (!status.ok()) {
            spdlog::debug("streams of another server are not listed: {}", status.error_message());
          }
          const MutexLock lock(mutex);
          --missing;
          answered.NotifyAll();
        });
  }
  const MutexLock lock(mutex);
  answered.Wait(mutex, [&] { return missing == 0; });
  for (const auto& asked : all) {
    streams.insert(streams.end(), asked->response.streams().begin(),
                   asked->response.streams().end());
  }
  return streams;
}

MessageSource<v1::WatchStreamResponse> ForwardWatch(const Call& call,
                                                    const OtherServers::Stub& owner,
                                                    const v1::WatchStreamRequest& request) {
  const auto handle = std::make_shared<WatchHandle>(ForwardedWatch::Start(call, owner, request));
  return [&call, handle](v1::WatchStreamResponse& message) {
    call.parking.WakeOn(handle->watch().signal());
    return handle->watch().Next(message);
  };
}

}  // namespace motiondb::server
