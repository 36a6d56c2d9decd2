#include "server/rpc/spectator.h"

#include <grpcpp/client_context.h>
#include <grpcpp/support/client_callback.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/rpc/other_servers.h"
#include "server/rpc/running_streams.h"
#include "server/translate/page.h"
#include "server/translate/resource_name.h"
#include "server/translate/status_mapping.h"
#include "storage/mutex.h"

namespace motiondb::server {
namespace {

using storage::MutexLock;

// The answers of a stream for one spectator.
class SpectatorSource {
 public:
  // `call` must outlive it.
  SpectatorSource(const Call& call, std::shared_ptr<RunningStream> stream)
      : call_(call), spectator_(std::move(stream)) {}

  // AwaitsChange if there is no newer answer yet.
  absl::StatusOr<bool> Next(v1::WatchStreamResponse& message) {
    RunningStream& stream = spectator_.stream();
    if (!std::exchange(begun_, true)) {
      *message.mutable_stream() = stream.Description();
      return true;
    }
    call_.parking.WakeOn(*stream.signal());
    call_.parking.WakeOn(*stream.database()->signal());
    const auto ended = stream.ended();  // before the last answer is taken
    if (auto answer = spectator_.Take()) {
      message = *std::move(answer);
      return true;
    }
    // Also if the database was created again.
    const auto current = call_.engine.FindDatabase(stream.database()->name());
    if (!current.ok()) return current.status();
    if (*current != stream.database()) {
      return core::WithReason(
          "DATABASE_NOT_FOUND",
          core::NotFound("database '{}' was deleted and created again", stream.database()->name()));
    }
    if (!ended) return AwaitsChange();
    if (!ended->ok()) return *ended;
    return false;
  }

 private:
  const Call& call_;
  RunningStream::Spectator spectator_;
  bool begun_ = false;
};

// Calls of ListStreams and WatchStream that concern streams of other servers of a shared store.

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

// The answers of other servers to ListStreams. Their calls share it: they may outlast the caller.
struct Answers {
  struct Asked {
    grpc::ClientContext context;
    v1::ListStreamsResponse response;
  };
  v1::ListStreamsRequest request;
  std::vector<std::unique_ptr<Asked>> asked;
  storage::Mutex mutex;
  storage::ConditionVariable answered;
  std::size_t missing ABSL_GUARDED_BY(mutex) = 0;
};

// Returns the streams that the other servers run. A server that does not answer within a second is
// left out. Blocks as long.
std::vector<v1::ObservedStream> StreamsOfOthers(const Call& call, OtherServers& others,
                                                const v1::ListStreamsRequest& request) {
  std::vector<v1::ObservedStream> streams;
  const auto stubs = others.All();
  if (!stubs.ok()) return streams;  // as if none answered
  const auto answers = std::make_shared<Answers>();
  answers->request = request;
  answers->request.set_this_server(true);
  for (const OtherServers::Stub& stub : *stubs) {
    auto& asked = *answers->asked.emplace_back(std::make_unique<Answers::Asked>());
    PassCaller(call, asked.context);
    asked.context.set_deadline(std::chrono::system_clock::now() + kMaxListTime);
    {
      const MutexLock lock(answers->mutex);
      ++answers->missing;
    }
    stub->async()->ListStreams(
        &asked.context, &answers->request, &asked.response, [answers](const grpc::Status& status) {
          if (!status.ok()) {
            spdlog::debug("streams of another server are not listed: {}", status.error_message());
          }
          const MutexLock lock(answers->mutex);
          --answers->missing;
          answers->answered.NotifyAll();
        });
  }
  const MutexLock lock(answers->mutex);
  answers->answered.Wait(answers->mutex, [&] {
    answers->mutex.AssertHeld();
    return answers->missing == 0;
  });
  for (const auto& asked : answers->asked) {
    streams.insert(streams.end(), asked->response.streams().begin(),
                   asked->response.streams().end());
  }
  return streams;
}

// Returns the messages of WatchStream of another server. It ends as the call there does;
// UNAVAILABLE if that server stops or cannot be reached.
MessageSource<v1::WatchStreamResponse> ForwardWatch(const Call& call,
                                                    const OtherServers::Stub& owner,
                                                    const v1::WatchStreamRequest& request) {
  const auto handle = std::make_shared<WatchHandle>(ForwardedWatch::Start(call, owner, request));
  return [&call, handle](v1::WatchStreamResponse& message) {
    call.parking.WakeOn(handle->watch().signal());
    return handle->watch().Next(message);
  };
}

}  // namespace

absl::Status ListStreams(const Call& call, const v1::ListStreamsRequest& request,
                         v1::ListStreamsResponse& response) {
  constexpr int kMaxStreams = 1000;
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id, ParseDatabaseName("parent", request.parent()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto database, call.engine.FindDatabase(id));
  std::vector<v1::ObservedStream> streams;
  if (call.others != nullptr && !request.this_server()) {
    // It blocks. Heavy calls leave a thread to the calls of other servers, which may ask this one.
    if (call.entry.allowed() == AllowedWork::kLightWork) return HeavyWork();
    streams = StreamsOfOthers(call, *call.others, request);
  }
  for (const auto& stream : call.streams.List(*database, kMaxStreams)) {
    streams.push_back(stream->Description());
  }
  std::ranges::stable_sort(streams, [](const auto& a, const auto& b) {
    return std::pair(a.start_time().seconds(), a.start_time().nanos()) <
           std::pair(b.start_time().seconds(), b.start_time().nanos());
  });
  PageBudget budget(kMaxStreams);
  for (v1::ObservedStream& description : streams) {
    if (!budget.Take(description.ByteSizeLong())) break;
    *response.add_streams() = std::move(description);
  }
  return absl::OkStatus();
}

absl::StatusOr<MessageSource<v1::WatchStreamResponse>> OpenWatchedStream(
    const Call& call, const v1::WatchStreamRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const MemberId id, ParseStreamName("name", request.name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto database, call.engine.FindDatabase(id.database));
  if (call.others != nullptr) {
    const auto owner = call.others->Find(id.id.substr(0, id.id.find('-')));
    if (owner.ok()) return ForwardWatch(call, *owner, request);
    if (!absl::IsNotFound(owner.status())) return owner.status();
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto stream, call.streams.Find(*database, id.id));
  const auto source = std::make_shared<SpectatorSource>(call, std::move(stream));
  return [source](v1::WatchStreamResponse& message) { return source->Next(message); };
}

}  // namespace motiondb::server
