#include <motiondb/v1/database.grpc.pb.h>
#include <motiondb/watch.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "client/connection.h"
#include "client/reconnect.h"

namespace motiondb::client {
namespace {

// Name of the object of a change; empty if the message only reports up_to_date.
std::string ChangedObject(const v1::WatchDatabaseResponse& message) {
  switch (message.change_case()) {
    case v1::WatchDatabaseResponse::kClip:
      return message.clip().name();
    case v1::WatchDatabaseResponse::kSegment:
      return message.segment().name();
    case v1::WatchDatabaseResponse::kDeleted:
      return message.deleted();
    case v1::WatchDatabaseResponse::kModelVersion:
      return std::to_string(message.model_version());
    case v1::WatchDatabaseResponse::CHANGE_NOT_SET:
      break;
  }
  return "";
}

}  // namespace

class Watch::Stream {
 public:
  Stream(std::shared_ptr<const Client::Connection> connection, v1::WatchDatabaseRequest request,
         WatchOptions options)
      : connection_(std::move(connection)),
        request_(std::move(request)),
        options_(std::move(options)),
        delays_(connection_->address_count()) {}
  ~Stream() {
    Cancel();
    if (reader_ != nullptr) reader_->Finish();
  }

  bool Next(v1::WatchDatabaseResponse& message) {
    while (result_.ok()) {
      if (reader_ == nullptr && !Open()) break;
      if (reader_->Read(&message)) {
        delays_.Reset();
        if (Accept(message)) return true;
      } else {
        WaitForRetry(Close());
      }
    }
    return false;
  }

  std::int64_t revision() const { return request_.after_revision(); }
  const absl::Status& result() const { return result_; }

  void Cancel() {
    const absl::MutexLock lock(&mutex_);
    is_cancelled_ = true;
    if (call_ != nullptr) call_->context.TryCancel();
  }

 private:
  // Returns false if the watch was cancelled.
  bool Open() {
    const absl::MutexLock lock(&mutex_);
    if (is_cancelled_) {
      result_ = absl::CancelledError("the watch was cancelled");
      return false;
    }
    call_ = connection_->Begin({.timeout = kNoTimeout}, DatabaseOf(request_));
    reader_ = call_->endpoint.databases->WatchDatabase(&call_->context, request_);
    return true;
  }

  // Returns the status of the connection that ended. A watch has no end, so it is an error.
  absl::Status Close() {
    const grpc::Status finished = reader_->Finish();
    reader_.reset();
    const absl::MutexLock lock(&mutex_);
    call_->is_cancelled = is_cancelled_;
    absl::Status status = connection_->Finish(finished, *call_);
    call_.reset();
    if (is_cancelled_) return absl::CancelledError("the watch was cancelled");
    if (status.ok()) return absl::UnavailableError("the server has ended the stream of changes");
    return status;
  }

  // Waits if a new connection may succeed; otherwise ends the watch.
  void WaitForRetry(const absl::Status& error) {
    const auto delay = delays_.Next(error);
    if (!delay) {
      result_ = error;
      return;
    }
    if (options_.on_reconnect) options_.on_reconnect(error, *delay);
    const absl::MutexLock lock(&mutex_);
    mutex_.AwaitWithTimeout(absl::Condition(&is_cancelled_), absl::FromChrono(*delay));
  }

  // Keeps track of the last complete transaction. Returns false for a change that Next has already
  // returned before a connection ended.
  bool Accept(v1::WatchDatabaseResponse& message) {
    if (open_revision_ && message.revision() > *open_revision_) Complete(*open_revision_);
    bool is_new = true;
    if (const std::string object = ChangedObject(message); !object.empty()) {
      open_revision_ = message.revision();
      is_new = returned_.insert(object).second;
    }
    if (!is_new) message.clear_change();
    if (message.up_to_date()) Complete(message.revision());
    return is_new || message.up_to_date();
  }

  void Complete(std::int64_t revision) {
    request_.set_after_revision(std::max(revision, request_.after_revision()));
    open_revision_.reset();
    returned_.clear();
  }

  const std::shared_ptr<const Client::Connection> connection_;
  v1::WatchDatabaseRequest request_;  // after_revision: the last complete transaction
  const WatchOptions options_;
  std::unique_ptr<grpc::ClientReader<v1::WatchDatabaseResponse>> reader_;
  ReconnectDelays delays_;
  std::optional<std::int64_t> open_revision_;  // of a transaction that may be incomplete
  std::set<std::string> returned_;             // its objects
  absl::Status result_;

  absl::Mutex mutex_;
  bool is_cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  std::unique_ptr<OutgoingCall> call_ ABSL_GUARDED_BY(mutex_);
};

Watch::Watch(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
Watch::Watch(Watch&&) noexcept = default;
Watch& Watch::operator=(Watch&&) noexcept = default;
Watch::~Watch() = default;

bool Watch::Next(v1::WatchDatabaseResponse& message) { return stream_->Next(message); }
std::int64_t Watch::revision() const { return stream_->revision(); }
absl::Status Watch::Finish() const { return stream_->result(); }
void Watch::Cancel() { stream_->Cancel(); }

Watch Client::WatchDatabase(const v1::WatchDatabaseRequest& request, WatchOptions options) const {
  return Watch(std::make_unique<Watch::Stream>(connection_, request, std::move(options)));
}

}  // namespace motiondb::client
