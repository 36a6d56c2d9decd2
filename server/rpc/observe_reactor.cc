#include "server/rpc/observe_reactor.h"

#include <atomic>
#include <memory>
#include <mutex>

#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "server/engine/query_memory.h"
#include "server/rpc/query_subject.h"
#include "server/rpc/silence_limit.h"
#include "server/translate/field_violation.h"
#include "server/translate/observe_message.h"

namespace motiondb::server {
namespace {

class ObserveReactor final
    : public grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse> {
 public:
  ObserveReactor(CallHost& host, grpc::CallbackServerContext& context)
      : engine_(host.engine),
        context_(context),
        entry_(host, context, MethodOf<v1::ObserveRequest>(), [this] { Stop(); }),
        silence_(engine_.workers(), host.limits.first_silence(),
                 host.limits.options().longest_silence, [this] { EndSilence(); }) {
    if (grpc::Status admission = entry_.Admission(); admission.ok()) {
      StartReading();
    } else {
      End(std::move(admission));
    }
  }

  void OnReadDone(bool ok) override {
    Do(Turn::kServer, [this, ok] {
      const absl::Status held = ok ? entry_.ReserveRequest(request_) : absl::OkStatus();
      entry_.Post([this, ok, held] { ok ? Work(held) : Close(); });
    });
  }
  void OnWriteDone(bool ok) override {
    writing_ = false;
    if (!ok && silent_) return End(entry_.Silent());
    if (!ok) return End({grpc::StatusCode::CANCELLED, "the client went away"});
    Read();
  }
  void OnDone() override { delete this; }

 private:
  // Who has something to do before the call goes on.
  enum class Turn { kClient, kServer, kNobody };

  // Starts what comes next, unless the call has ended. Under the lock, so that nobody ends the
  // call, which deletes this, in between.
  template <typename Start>
  void Do(Turn turn, Start start) {
    const std::lock_guard lock(mutex_);
    if (turn_ == Turn::kNobody) return;
    turn_ = turn;
    start();
  }

  void Work(const absl::Status& held) {
    const grpc::Status status =
        RunHandler(entry_.cancelled(), [&] { return held.ok() ? Take() : held; });
    if (!status.ok()) return End(status);
    if (request_.part_case() == v1::ObserveRequest::kStart) return Read();
    silence_.Restart();
    Do(Turn::kClient, [this] {
      writing_ = true;
      StartWrite(&response_);
    });
  }

  // Half-closed; where the call was cancelled instead, nobody reads the status. A stream without
  // any message was not checked yet.
  void Close() {
    End(session_ != nullptr ? grpc::Status::OK : RunHandler(entry_.cancelled(), [this] {
      return entry_.Check(request_);
    }));
  }

  void Read() {
    silence_.Restart();
    StartReading();
  }

  void StartReading() {
    {
      const std::lock_guard lock(mutex_);
      if (turn_ == Turn::kNobody) return;
      turn_ = stopping_ ? Turn::kNobody : Turn::kClient;
      if (turn_ == Turn::kClient) return StartRead(&request_);
    }
    Finish(entry_.End(Stopping()));
  }

  // Once, whoever comes first; the last thing that its thread does here.
  void End(grpc::Status status) {
    bool first = false;
    Do(Turn::kNobody, [&] { first = true; });
    if (first) Finish(entry_.End(std::move(status)));
  }

  // The server stops. A call that waits for its client ends at once, one that works when it has
  // answered.
  void Stop() {
    stopping_ = true;
    EndInClientsTurn(Stopping);
  }

  void EndSilence() {
    // A status would wait behind the answer that the client does not take.
    if (!writing_) return EndInClientsTurn([this] { return entry_.Silent(); });
    silent_ = true;
    context_.TryCancel();
  }

  // `status_of` is asked when nobody else works on the call any more.
  template <typename StatusOf>
  void EndInClientsTurn(StatusOf status_of) {
    {
      const std::lock_guard lock(mutex_);
      if (turn_ != Turn::kClient) return;
      turn_ = Turn::kNobody;
    }
    Finish(entry_.End(status_of()));
  }

  absl::Status Take() {
    MOTIONDB_RETURN_IF_ERROR(session_ == nullptr ? entry_.Check(request_) : entry_.Recheck());
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
    const v1::ObserveStart& start = request_.start();
    MOTIONDB_ASSIGN_OR_RETURN(QuerySubject subject,
                              FindSubject(engine_, "start.database", start.database()));
    MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, subject.database->scheme());
    MOTIONDB_ASSIGN_OR_RETURN(ObserveSetup setup,
                              SetupFrom(start, subject.snapshot->model, scheme->set));
    marker_names_ = setup.marker_names;
    options_ = setup.options;
    MOTIONDB_RETURN_IF_ERROR(Reserve(subject.snapshot->model));
    top_count_ = start.top_count();
    auto session = ObserveSession::Open(engine_, std::move(subject.database),
                                        std::move(subject.snapshot), std::move(setup));
    if (!session.ok()) return AtField("start", session.status());
    session_ = *std::move(session);
    return absl::OkStatus();
  }

  // What the stream keeps, under a model.
  absl::Status Reserve(const core::Model& model) {
    memory_ = BytesToObserve(model, options_);
    return entry_.ReserveWork(memory_.kept);
  }

  absl::Status Answer() {
    if (session_ == nullptr) return FieldViolation("part", "expected a start first");
    const v1::ObservedFrames& frames = request_.frames();
    MOTIONDB_ASSIGN_OR_RETURN(const core::FrameMatrix positions, FramesFrom(frames, marker_names_));
    MOTIONDB_RETURN_IF_ERROR(entry_.ReserveWork(memory_.kept + memory_.answer));
    auto step = session_->Take(frames.first_frame(), positions, entry_.cancelled());
    if (!step.ok()) return AtField("frames", step.status());
    MOTIONDB_RETURN_IF_ERROR(step->model_replaced ? Reserve(session_->model())
                                                  : entry_.ReserveWork(memory_.kept));
    response_.Clear();
    SetStep(*step, top_count_, response_);
    return absl::OkStatus();
  }

  Engine& engine_;
  v1::ObserveRequest request_;
  v1::ObserveResponse response_;
  std::vector<std::string> marker_names_;
  int top_count_ = 0;
  core::ObserverOptions options_;
  ObserveMemory memory_;
  std::unique_ptr<ObserveSession> session_;
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  Turn turn_ = Turn::kClient;
  std::atomic<bool> writing_ = false;  // until the client has room for the answer
  std::atomic<bool> silent_ = false;
  grpc::CallbackServerContext& context_;
  // Last, for they call what is above.
  CallEntry entry_;
  SilenceLimit silence_;
};

}  // namespace

grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* NewObserveReactor(
    CallHost& host, grpc::CallbackServerContext& context) {
  return new ObserveReactor(host, context);
}

}  // namespace motiondb::server
