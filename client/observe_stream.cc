#include <fmt/format.h>
#include <motiondb/call_error.h>
#include <motiondb/observe_stream.h>
#include <motiondb/v1/observe.grpc.pb.h>

#include <algorithm>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client/call_failure.h"
#include "client/connection.h"
#include "client/reconnect.h"

namespace motiondb::client {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Without a server, Send keeps so much and then blocks, as flow control does with a server.
constexpr std::size_t kMaxUnansweredBytes = std::size_t{8} << 20;

milliseconds Since(Clock::time_point begin) {
  return std::chrono::duration_cast<milliseconds>(Clock::now() - begin);
}

}  // namespace

// The thread in Receive reads the stream, opens it again, and then writes the kept messages between
// the answers. Until all are written, Send only adds messages.
class ObserveStream::Call {
 public:
  Call(std::shared_ptr<const Client::Connection> connection, const v1::ObserveStart& start,
       ObserveOptions options)
      : connection_(std::move(connection)),
        options_(std::move(options)),
        begin_(Clock::now()),
        delays_(connection_->address_count()),
        sent_(start) {
    *start_.mutable_start() = start;
    const absl::MutexLock lock(&mutex_);
    Open();
  }
  ~Call() {
    {
      const absl::MutexLock lock(&mutex_);
      if (has_ended_) return;
    }
    Cancel();
    Finish().IgnoreError();
  }

  bool Send(std::int64_t first_frame, int frame_count, std::span<const float> positions_m) {
    v1::ObserveRequest message;
    v1::ObservedFrames& frames = *message.mutable_frames();
    frames.set_first_frame(first_frame);
    frames.set_frame_count(frame_count);
    frames.set_positions(positions_m.data(), positions_m.size_bytes());
    const absl::MutexLock lock(&mutex_);
    mutex_.Await(absl::Condition(this, &Call::CanSend));
    if (has_ended_) return false;
    const bool writes = IsLive();
    sent_.Add(std::move(message));
    if (writes) WriteNext();
    return true;
  }

  void EndOfFrames() {
    const absl::MutexLock lock(&mutex_);
    ends_ = true;
    WriteEnd();
  }

  bool Receive(v1::ObserveResponse& answer) {
    while (true) {
      {
        const absl::MutexLock lock(&mutex_);
        if (has_ended_) return false;
        while (!is_broken_ && sent_.CanWriteAhead()) WriteNext();
        WriteEnd();
      }
      if (!stream_->Read(&answer)) {
        Reconnect();
      } else if (Accept(answer)) {
        return true;
      }
    }
  }

  absl::Status Finish() {
    v1::ObserveResponse unread;
    while (Receive(unread)) {
    }
    const absl::MutexLock lock(&mutex_);
    return result_;
  }

  void Cancel() {
    const absl::MutexLock lock(&mutex_);
    is_cancelled_ = true;
    call_->is_cancelled = true;
    call_->context.TryCancel();
  }

 private:
  // Whether Send may write to the present server.
  bool IsLive() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return !is_broken_ && sent_.is_written();
  }
  bool CanSend() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (has_ended_) return true;
    return IsLive() ? !is_writing_ : sent_.unanswered_bytes() < kMaxUnansweredBytes;
  }
  bool IsIdle() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !is_writing_; }

  // Calls `write` without the mutex, since flow control may block it.
  template <typename Write>
  void WithoutMutex(const Write& write) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    is_writing_ = true;
    mutex_.Unlock();
    const bool ok = write();
    mutex_.Lock();
    is_writing_ = false;
    if (!ok) is_broken_ = true;
  }
  void WriteNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const v1::ObserveRequest& message = sent_.NextToWrite();
    WithoutMutex([&] { return stream_->Write(message); });
  }
  // Half-closes the stream when all frames are written.
  void WriteEnd() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!ends_ || is_end_written_ || is_writing_ || !IsLive()) return;
    is_end_written_ = true;
    WithoutMutex([&] { return stream_->WritesDone(); });
  }

  void Open() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const milliseconds limit = options_.timeout.value_or(kNoTimeout);
    const milliseconds timeout =
        limit == kNoTimeout ? limit : std::max(limit - Since(begin_), milliseconds(1));
    stream_.reset();  // before its context
    call_ = connection_->Begin({.timeout = timeout}, DatabaseOf(start_.start()));
    stream_ = call_->endpoint.observations->Observe(&call_->context);
    sent_.WriteAgain();
    is_broken_ = is_end_written_ = false;
    WithoutMutex([&] { return stream_->Write(start_); });
  }

  // The stream has ended: opens it again, or sets the result.
  void Reconnect() {
    const absl::MutexLock lock(&mutex_);
    is_broken_ = true;
    mutex_.Await(absl::Condition(this, &Call::IsIdle));
    const absl::Status status = connection_->Finish(stream_->Finish(), *call_);
    if (status.ok() || is_cancelled_) return End(status);
    if (ends_ && sent_.is_answered()) return End(absl::OkStatus());
    // A limit of the first server refuses a stream; a limit of a further one may be temporary.
    if (!absl::IsUnavailable(status) && !has_answer_) return End(status);
    const auto delay = delays_.Next(status);
    if (!lost_) lost_ = Lost{status, Clock::now()};
    if (!delay || Since(lost_->time) + *delay >= options_.reconnect_timeout) return End(status);
    mutex_.AwaitWithTimeout(absl::Condition(&is_cancelled_), absl::FromChrono(*delay));
    if (is_cancelled_) return End(absl::CancelledError("the stream was cancelled"));
    Open();
  }

  void End(absl::Status status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    has_ended_ = true;
    result_ = std::move(status);
    if (!absl::IsUnavailable(result_) || sent_.is_answered()) return;
    result_ =
        WithMessage(result_, fmt::format("{}; {} frames from frame {} on have no answer",
                                         std::string(result_.message()), sent_.unanswered_frames(),
                                         sent_.first_unanswered()));
  }

  // Makes `answer` continue those of earlier servers. Returns false if an earlier server has
  // already answered the message.
  bool Accept(v1::ObserveResponse& answer) {
    std::optional<ObserveReconnect> reconnect;
    bool is_new = false;
    {
      const absl::MutexLock lock(&mutex_);
      delays_.Reset();
      if (lost_) {
        reconnect = {lost_->error, Since(lost_->time), sent_.forgotten_frames(),
                     sent_.first_frame()};
        lost_.reset();
        has_moved_ = has_answer_;
        earlier_late_ = last_.late_frames();
        earlier_missing_ = last_.missing_frames();
      }
      is_new = sent_.Answered();
      if (is_new) {
        answer.set_late_frames(answer.late_frames() + earlier_late_);
        answer.set_missing_frames(answer.missing_frames() + earlier_missing_);
        if (has_moved_ && answer.model_version() != last_.model_version()) {
          answer.set_model_replaced(true);
        }
        has_moved_ = false;
        has_answer_ = true;
        last_.set_late_frames(answer.late_frames());
        last_.set_missing_frames(answer.missing_frames());
        last_.set_model_version(answer.model_version());
      } else {
        // The new server counts these again.
        earlier_late_ = last_.late_frames() - answer.late_frames();
        earlier_missing_ = last_.missing_frames() - answer.missing_frames();
      }
    }
    if (reconnect && options_.on_reconnect) options_.on_reconnect(*reconnect);
    return is_new;
  }

  // The end of the stream at an earlier server.
  struct Lost {
    absl::Status error;
    Clock::time_point time;
  };

  const std::shared_ptr<const Client::Connection> connection_;
  const ObserveOptions options_;
  const Clock::time_point begin_;
  v1::ObserveRequest start_;

  absl::Mutex mutex_;
  std::unique_ptr<OutgoingCall> call_ ABSL_GUARDED_BY(mutex_);
  // Replaced by the thread in Receive, while no thread writes.
  std::unique_ptr<grpc::ClientReaderWriter<v1::ObserveRequest, v1::ObserveResponse>> stream_;
  ReconnectDelays delays_ ABSL_GUARDED_BY(mutex_);
  SentFrames sent_ ABSL_GUARDED_BY(mutex_);
  bool is_writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_broken_ ABSL_GUARDED_BY(mutex_) = false;
  bool ends_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_end_written_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool has_ended_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status result_ ABSL_GUARDED_BY(mutex_);
  std::optional<Lost> lost_ ABSL_GUARDED_BY(mutex_);
  bool has_answer_ ABSL_GUARDED_BY(mutex_) = false;
  bool has_moved_ ABSL_GUARDED_BY(mutex_) = false;    // the next answer is the first of a server
  v1::ObserveResponse last_ ABSL_GUARDED_BY(mutex_);  // version and counts of the last answer
  // Added to the counts of the present server.
  std::int64_t earlier_late_ ABSL_GUARDED_BY(mutex_) = 0;
  std::int64_t earlier_missing_ ABSL_GUARDED_BY(mutex_) = 0;
};

ObserveStream::ObserveStream(std::unique_ptr<Call> call) : call_(std::move(call)) {}
ObserveStream::ObserveStream(ObserveStream&&) noexcept = default;
ObserveStream& ObserveStream::operator=(ObserveStream&&) noexcept = default;
ObserveStream::~ObserveStream() = default;

bool ObserveStream::Send(std::int64_t first_frame, int frame_count,
                         std::span<const float> positions_m) {
  return call_->Send(first_frame, frame_count, positions_m);
}
void ObserveStream::EndOfFrames() { call_->EndOfFrames(); }
bool ObserveStream::Receive(v1::ObserveResponse& answer) { return call_->Receive(answer); }
absl::Status ObserveStream::Finish() { return call_->Finish(); }
void ObserveStream::Cancel() { call_->Cancel(); }

ObserveStream Client::Observe(const v1::ObserveStart& start, ObserveOptions options) const {
  return ObserveStream(
      std::make_unique<ObserveStream::Call>(connection_, start, std::move(options)));
}

absl::Status Client::WatchStream(
    const v1::WatchStreamRequest& request,
    const std::function<absl::Status(const v1::WatchStreamResponse&)>& on_message,
    CallOptions options) const {
  if (!options.timeout) options.timeout = kNoTimeout;
  return connection_->ReadStream(&Endpoint::observations, &v1::ObserveService::Stub::WatchStream,
                                 request, on_message, options);
}

}  // namespace motiondb::client
