#include <atomic>
#include <chrono>
#include <memory>
#include <utility>

#include "core/motion/error.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/observe.pb.h"
#include "server/engine/query/observe_session.h"
#include "server/engine/work/clock.h"
#include "server/rpc/call.h"
#include "server/rpc/parking.h"
#include "server/rpc/running_streams.h"
#include "server/rpc/services.h"
#include "server/rpc/spectator.h"
#include "server/translate/message_fields.h"
#include "server/translate/observation_message.h"
#include "server/translate/resource_name.h"
#include "storage/mutex.h"

namespace motiondb::server {

namespace {

class ObserveReactor final
    : public grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse> {
 public:
  ObserveReactor(ServiceContext& host, grpc::CallbackServerContext& context)
      : engine_(host.engine),
        streams_(host.streams),
        parking_(host.engine.workers()),
        context_(context),
        entry_(host, context, MethodOf<v1::ObserveRequest>(), [this] { Stop(); }),
        idle_timer_(engine_.workers(), host.limits.first_message_limit(),
                    host.limits.options().idle_limit, [this] { OnIdle(); }) {
    if (grpc::Status admission = entry_.Admission(); admission.ok()) {
      StartReading();
    } else {
      End(std::move(admission));
    }
  }

  void OnReadDone(bool ok) override {
    received_ = std::chrono::steady_clock::now();
    Do(Turn::kServer, [this, ok] {
      const absl::Status reserved = ok ? entry_.ReserveRequest(request_) : absl::OkStatus();
      entry_.Post([this, ok, reserved] { ok ? Work(reserved) : Close(); });
    });
  }
  void OnWriteDone(bool ok) override {
    writing_ = false;
    if (!ok && idle_) return End(entry_.IdleStatus());
    if (!ok) return End({grpc::StatusCode::CANCELLED, "the client disconnected"});
    Read();
  }
  void OnCancel() override { parking_.Wake(); }
  void OnDone() override { delete this; }

 private:
  // Whose action the call waits for; kNobody: the call has ended.
  enum class Turn { kClient, kServer, kNobody };

  // Sets the turn and calls `start`, unless the call has ended. With the lock, so that no other
  // thread can end the call, which deletes this.
  template <typename Start>
  void Do(Turn turn, Start start) {
    const storage::MutexLock lock(mutex_);
    if (turn_ == Turn::kNobody) return;
    turn_ = turn;
    start();
  }

  void Work(const absl::Status& reserved) {
    bool waits = false;
    parking_.BeginStep();
    const grpc::Status status = RunHandler(entry_.cancelled(), [&] {
      absl::Status taken = reserved.ok() ? Take() : reserved;
      waits = IsAwaitingChange(taken);
      return taken;
    });
    if (waits && parking_.stopped()) return End(StoppingStatus());
    if (waits) {
      return parking_.Park(entry_.deadline(),
                           [this] { entry_.Post([this] { Work(absl::OkStatus()); }); });
    }
    if (!status.ok()) return End(status);
    if (request_.part_case() == v1::ObserveRequest::kStart) return Read();
    idle_timer_.Restart();
    Do(Turn::kClient, [this] {
      writing_ = true;
      StartWrite(&response_);
    });
  }

  // The client has half-closed the stream, or has cancelled and reads no status. A stream without a
  // message is checked here.
  void Close() {
    End(session_ != nullptr ? grpc::Status::OK : RunHandler(entry_.cancelled(), [this] {
      return entry_.Check(request_);
    }));
  }

  void Read() {
    idle_timer_.Restart();
    StartReading();
  }

  void StartReading() {
    {
      const storage::MutexLock lock(mutex_);
      if (turn_ == Turn::kNobody) return;
      turn_ = stopping_ ? Turn::kNobody : Turn::kClient;
      if (turn_ == Turn::kClient) return StartRead(&request_);
    }
    Leave(StoppingStatus());
  }

  // Ends the call at most once. The calling thread must not use this object afterwards.
  void End(grpc::Status status) {
    bool is_first = false;
    Do(Turn::kNobody, [&] { is_first = true; });
    if (is_first) Leave(std::move(status));
  }

  // Ends the call, and with it its spectators' calls.
  void Leave(grpc::Status status) {
    if (registration_ != nullptr) {
      const bool stops = status.error_code() == grpc::StatusCode::UNAVAILABLE;
      registration_->stream().End(stops ? ServerStopping() : absl::OkStatus());
      registration_.reset();
    }
    Finish(entry_.End(std::move(status)));
  }

  // The server stops. A call that waits for its client ends immediately, a busy one after its
  // response.
  void Stop() {
    stopping_ = true;
    parking_.Stop();
    EndInClientsTurn(StoppingStatus);
  }

  void OnIdle() {
    // A status would be queued behind the response that the client does not read.
    if (!writing_) return EndInClientsTurn([this] { return entry_.IdleStatus(); });
    idle_ = true;
    context_.TryCancel();
  }

  // Calls `status_of` when no other thread works on the call.
  template <typename StatusOf>
  void EndInClientsTurn(StatusOf status_of) {
    {
      const storage::MutexLock lock(mutex_);
      if (turn_ != Turn::kClient) return;
      turn_ = Turn::kNobody;
    }
    Leave(status_of());
  }

  absl::Status Take() {
    MOTIONDB_RETURN_IF_ERROR(std::exchange(checked_, true) ? entry_.Recheck()
                                                           : entry_.Check(request_));
    switch (request_.part_case()) {
      case v1::ObserveRequest::kStart:
        return Open();
      case v1::ObserveRequest::kFrames:
        return Answer();
      case v1::ObserveRequest::PART_NOT_SET:
        return FieldViolation("part", "expected one of start, frames");
    }
    return absl::OkStatus();
  }

  absl::Status Open() {
    if (session_ != nullptr) return FieldViolation("start", "expected once, at the beginning");
    auto session = OpenSession(request_.start());
    if (!session.ok()) return core::Within("start", session.status());
    session_ = *std::move(session);
    v1::ObservedStream description;
    SetTimestamp(NowMicroseconds(), *description.mutable_start_time());
    if (const std::string caller = entry_.principal(); caller != kAnonymous) {
      description.set_caller(caller);
    }
    const ObserveSetup& setup = session_->setup();
    description.set_frame_rate_hz(setup.frame_rate_hz);
    description.mutable_marker_names()->Add(setup.marker_names.begin(), setup.marker_names.end());
    registration_ = streams_.Add(session_->database(), std::move(description));
    return absl::OkStatus();
  }

  absl::StatusOr<std::unique_ptr<ObserveSession>> OpenSession(const v1::ObserveStart& start) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::string id,
                              ParseDatabaseName("database", start.database()));
    MOTIONDB_ASSIGN_OR_RETURN(ObserveSetup setup, ParseObserveSetup(start));
    top_count_ = start.top_count();
    const WorkOptions terms{
        .cancelled = entry_.cancelled(),
        .reserve = [this](std::int64_t bytes) { return entry_.ReserveWork(bytes); },
        .wake_on = [this](ChangeSignal& signal) { parking_.WakeOn(signal); }};
    MOTIONDB_ASSIGN_OR_RETURN(Query query, Query::Begin(engine_, id, terms, setup.scope));
    return ObserveSession::Open(std::move(query), std::move(setup));
  }

  absl::Status Answer() {
    if (session_ == nullptr) return FieldViolation("part", "expected a start first");
    const v1::ObservedFrames& frames = request_.frames();
    MOTIONDB_ASSIGN_OR_RETURN(const ObserveStep step,
                              session_->Take(frames.first_frame(), FramesFrom(frames)));
    response_.Clear();
    SetStep(step, top_count_, response_);
    Publish();
    return absl::OkStatus();
  }

  // Without spectators it only counts.
  void Publish() {
    RunningStream& stream = registration_->stream();
    const auto number = stream.CountAnswer(response_.frame());
    if (!number) return;
    v1::WatchStreamResponse published;
    *published.mutable_answer() = response_;
    if (const auto positions = session_->NewestPositions()) {
      AppendPacked(positions->data(), static_cast<std::size_t>(positions->size()),
                   *published.mutable_marker_positions());
    }
    published.set_latency_seconds(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - received_).count());
    stream.Publish(*number, std::move(published));
  }

  Engine& engine_;
  RunningStreams& streams_;
  std::chrono::steady_clock::time_point received_;  // the last message
  v1::ObserveRequest request_;
  v1::ObserveResponse response_;
  int top_count_ = 0;
  std::unique_ptr<ObserveSession> session_;
  std::unique_ptr<RunningStreams::Registration> registration_;  // with session_, until the end
  bool checked_ = false;
  Parking parking_;
  std::atomic<bool> stopping_ = false;
  storage::Mutex mutex_;
  Turn turn_ ABSL_GUARDED_BY(mutex_) = Turn::kClient;
  std::atomic<bool> writing_ = false;  // until the flow-control window has room for the response
  std::atomic<bool> idle_ = false;
  grpc::CallbackServerContext& context_;
  // Last: their callbacks use the members above.
  CallContext entry_;
  IdleTimer idle_timer_;
};

}  // namespace

grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* NewObserveReactor(
    ServiceContext& host, grpc::CallbackServerContext& context) {
  return new ObserveReactor(host, context);
}

namespace {

absl::Status Represent(const Call& call, const v1::RepresentRequest& request,
                       v1::RepresentResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id,
                            ParseDatabaseName("database", request.database()));
  MOTIONDB_ASSIGN_OR_RETURN(const Query query, Query::Begin(call.engine, id, call.work_options()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const Observation observation,
      ParseObservation("observation", request.observation(), query.database()->name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto markers, query.Markers(observation));
  SetMarkers(markers, *response.mutable_markers());
  return absl::OkStatus();
}

class ObserveServiceImpl final : public v1::ObserveService::CallbackService {
 public:
  explicit ObserveServiceImpl(ServiceContext& host) : host_(host) {}

  grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* Observe(
      grpc::CallbackServerContext* context) override {
    return NewObserveReactor(host_, *context);
  }
  grpc::ServerUnaryReactor* Represent(grpc::CallbackServerContext* context,
                                      const v1::RepresentRequest* request,
                                      v1::RepresentResponse* response) override {
    return Answer<server::Represent>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* ListStreams(grpc::CallbackServerContext* context,
                                        const v1::ListStreamsRequest* request,
                                        v1::ListStreamsResponse* response) override {
    return Answer<server::ListStreams>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::WatchStreamResponse>* WatchStream(
      grpc::CallbackServerContext* context, const v1::WatchStreamRequest* request) override {
    return new StreamReactor<v1::WatchStreamRequest, v1::WatchStreamResponse>(
        host_, context, request, OpenWatchedStream);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeObserveService(ServiceContext& host) {
  return std::make_unique<ObserveServiceImpl>(host);
}

}  // namespace motiondb::server
