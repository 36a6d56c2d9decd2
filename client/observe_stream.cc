#include <motiondb/observe_stream.h>
#include <motiondb/v1/observe.grpc.pb.h>

#include <utility>

#include "client/connection.h"

namespace motiondb::client {

class ObserveStream::Call {
 public:
  Call(std::shared_ptr<const Client::Connection> connection, const v1::ObserveStart& start,
       CallOptions options)
      : connection_(std::move(connection)), call_(WithTimeout(options)) {
    connection_->Prepare(call_);
    stream_ = connection_->observations->Observe(&call_.context);
    *request_.mutable_start() = start;
    stream_->Write(request_);
  }
  ~Call() {
    if (finished_) return;
    Cancel();
    Finish().IgnoreError();
  }

  bool Send(std::int64_t first_frame, int frame_count, std::span<const float> positions_m) {
    v1::ObservedFrames& frames = *request_.mutable_frames();
    frames.set_first_frame(first_frame);
    frames.set_frame_count(frame_count);
    frames.set_positions(positions_m.data(), positions_m.size_bytes());
    return stream_->Write(request_);
  }
  void EndOfFrames() { stream_->WritesDone(); }
  bool Receive(v1::ObserveResponse& answer) { return stream_->Read(&answer); }
  absl::Status Finish() {
    v1::ObserveResponse unread;
    while (stream_->Read(&unread)) {
    }
    finished_ = true;
    return connection_->Finish(stream_->Finish(), call_);
  }
  void Cancel() {
    call_.is_cancelled = true;
    call_.context.TryCancel();
  }

 private:
  // A stream has no time limit by default.
  static CallOptions WithTimeout(CallOptions options) {
    if (!options.timeout) options.timeout = kNoTimeout;
    return options;
  }

  const std::shared_ptr<const Client::Connection> connection_;
  OutgoingCall call_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ObserveRequest, v1::ObserveResponse>> stream_;
  v1::ObserveRequest request_;
  bool finished_ = false;
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

ObserveStream Client::Observe(const v1::ObserveStart& start, CallOptions options) const {
  return ObserveStream(std::make_unique<ObserveStream::Call>(connection_, start, options));
}

absl::Status Client::WatchStream(
    const v1::WatchStreamRequest& request,
    const std::function<absl::Status(const v1::WatchStreamResponse&)>& on_message,
    CallOptions options) const {
  if (!options.timeout) options.timeout = kNoTimeout;
  return connection_->ReadStream(*connection_->observations, &v1::ObserveService::Stub::WatchStream,
                                 request, on_message, options);
}

}  // namespace motiondb::client
