#include "server/http2/call_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "server/http2/grpc_wire.h"
#include "server/rpc/call_context.h"
#include "server/rpc/call_identity.h"
#include "server/security/attempt_limit.h"
#include "server/security/authorize.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

// Memory that gRPC and this class need for a call, besides its messages.
constexpr std::int64_t kCallBytes = 24 << 10;
constexpr std::int64_t kHeaderCopies = 6;       // here, at both ends of gRPC's call, in the handler
constexpr std::int64_t kMessageOverhead = 256;  // of each queued message
constexpr std::size_t kSmallMessageBytes = 4 << 10;  // its parsed size is not computed
// For headers that HTTP/2 and gRPC add to those of the caller.
constexpr std::size_t kExtraHeaderBytes = 16 << 10;
constexpr int kMaxHeaderFactor = 4;            // times the limit: the connection ends
constexpr std::size_t kHeaderOverhead = 32;    // of each header, as RFC 9113 counts it
constexpr std::size_t kMaxQueuedMessages = 2;  // if more, the flow-control window does not grow

grpc::Status Refusal(grpc::StatusCode code, const std::string& message) { return {code, message}; }

std::vector<nghttp2_nv> Views(const HeaderList& headers) {
  std::vector<nghttp2_nv> views;
  const auto bytes = [](const std::string& text) {
    return reinterpret_cast<std::uint8_t*>(const_cast<char*>(text.data()));
  };
  for (const auto& [name, value] : headers) {
    views.push_back({bytes(name), bytes(value), name.size(), value.size(), NGHTTP2_NV_FLAG_NONE});
  }
  return views;
}

ssize_t ReadAnswer(nghttp2_session*, std::int32_t, std::uint8_t* into, std::size_t size,
                   std::uint32_t* flags, nghttp2_data_source* source, void*) {
  return static_cast<CallStream*>(source->ptr)->Send({into, size}, *flags);
}

}  // namespace

CallStream::CallStream(CallBridge& bridge, std::shared_ptr<StreamConnection> host, std::int32_t id,
                       bool exempt)
    : bridge_(bridge),
      host_(std::move(host)),
      id_(id),
      exempt_(exempt),
      memory_(bridge.memory, AttemptSource(AddressOf(host_->peer()))) {}

bool CallStream::AddHeader(std::string_view name, std::string_view value) {
  header_bytes_ += name.size() + value.size() + kHeaderOverhead;
  const auto limit = static_cast<std::size_t>(bridge_.limits.options().max_metadata_bytes);
  if (header_bytes_ > kMaxHeaderFactor * limit + kExtraHeaderBytes) return false;
  struct Known {
    std::string_view name;
    std::string CallStream::*value;
  };
  // gRPC gets no other header, because the server uses none.
  static constexpr Known kKnown[] = {{":method", &CallStream::method_},
                                     {":path", &CallStream::path_},
                                     {"content-type", &CallStream::content_type_},
                                     {"grpc-timeout", &CallStream::timeout_},
                                     {"grpc-encoding", &CallStream::encoding_},
                                     {"authorization", &CallStream::authorization_},
                                     {"x-request-id", &CallStream::request_id_}};
  for (const Known& known : kKnown) {
    if (name == known.name && (this->*known.value).empty()) this->*known.value = value;
  }
  return true;
}

void CallStream::Begin() {
  if (detached_ || refused_) return;
  if (method_ != "POST") return RespondHttp(405);
  if (!content_type_.starts_with("application/grpc")) return RespondHttp(415);
  if (const absl::Status metadata = bridge_.limits.CheckMetadata(header_bytes_); !metadata.ok()) {
    return Refuse(ToGrpcStatus(metadata));
  }
  if (!encoding_.empty() && encoding_ != "identity") {
    return Refuse(Refusal(grpc::StatusCode::UNIMPLEMENTED,
                          "compressed messages are not supported; send them uncompressed"));
  }
  const auto headers = kHeaderCopies * static_cast<std::int64_t>(header_bytes_);
  if (const absl::Status reserved = Reserve(headers + (exempt_ ? 0 : kCallBytes)); !reserved.ok()) {
    return Refuse(ToGrpcStatus(reserved));
  }
  if (const auto timeout = ParseTimeout(timeout_)) {
    context_.set_deadline(
        std::chrono::system_clock::now() +
        std::chrono::duration_cast<std::chrono::system_clock::duration>(*timeout));
  } else if (!timeout_.empty()) {
    return Refuse(Refusal(grpc::StatusCode::INVALID_ARGUMENT,
                          "grpc-timeout: expected at most eight digits and a unit, such as 250m"));
  }
  const auto* const rpc = FindRpc(path_);
  streams_ = rpc != nullptr && rpc->client_streaming();
  checked_ = true;
  request_latest_ = Clock::now() + bridge_.limits.options().idle_limit;
  BeginCall();
}

// Begins the call if it is ready. A call with one request message begins when the message is
// complete: gRPC 1.51 never frees such a call if the message does not arrive.
void CallStream::BeginCall() {
  if (!checked_ || self_ != nullptr || refused_ || ended_ || detached_) return;
  if (!streams_ && queue_.empty()) {
    if (request_ended_) {
      Refuse(Refusal(grpc::StatusCode::INVALID_ARGUMENT, "expected one request message, got none"));
    }
    return;
  }
  request_latest_ = Clock::time_point::max();
  // gRPC 1.51 crashes if an in-process call begins after the server was shut down.
  if (host_->draining()) return Refuse(StoppingStatus());
  context_.AddMetadata(kPeerMetadata, host_->peer());
  if (!host_->common_name().empty()) {
    context_.AddMetadata(kCommonNameMetadata, host_->common_name());
  }
  if (!authorization_.empty())
    context_.AddMetadata("authorization", PrintableAscii(authorization_));
  if (!request_id_.empty()) context_.AddMetadata("x-request-id", PrintableAscii(request_id_));
  self_ = shared_from_this();
  bridge_.calls.PrepareBidiStreamingCall(&context_, path_, {}, this);
  AddHold();
  holding_ = reading_ = true;
  StartRead(&incoming_);
  StartCall();
  WriteNext();
}

void CallStream::Receive(std::span<const std::uint8_t> data) {
  nghttp2_session_consume_connection(host_->session(), data.size());
  if (queue_.size() < kMaxQueuedMessages || refused_ || ended_) {
    nghttp2_session_consume_stream(host_->session(), id_, data.size());
  } else {
    uncredited_ += data.size();
  }
  while (!data.empty() && !refused_ && !ended_) {
    if (prefix_bytes_ < kMessagePrefixBytes) {
      prefix_[prefix_bytes_++] = data.front();
      data = data.subspan(1);
      if (prefix_bytes_ == kMessagePrefixBytes) TakePrefix();
      continue;
    }
    const std::size_t size = std::min(data.size(), GRPC_SLICE_LENGTH(message_) - message_bytes_);
    std::memcpy(GRPC_SLICE_START_PTR(message_) + message_bytes_, data.data(), size);
    message_bytes_ += size;
    data = data.subspan(size);
    if (message_bytes_ == GRPC_SLICE_LENGTH(message_)) TakeMessage();
  }
}

void CallStream::TakePrefix() {
  if (IsCompressed(prefix_)) {
    return Refuse(Refusal(grpc::StatusCode::UNIMPLEMENTED,
                          "compressed messages are not supported; send them uncompressed"));
  }
  const std::uint32_t length = MessageLength(prefix_);
  if (length > bridge_.max_message_bytes) {
    return Refuse(Refusal(grpc::StatusCode::RESOURCE_EXHAUSTED,
                          fmt::format("expected a message of at most {} bytes "
                                      "(--max-message-mib), got {} bytes",
                                      bridge_.max_message_bytes, length)));
  }
  message_reserved_ = 0;
  if (!ReserveForMessage(kMessageOverhead + length)) return;
  message_ = grpc_slice_malloc(length);
  message_bytes_ = 0;
  if (length == 0) TakeMessage();
}

void CallStream::TakeMessage() {
  const grpc::Slice slice(message_, grpc::Slice::STEAL_REF);
  message_ = grpc_empty_slice();
  prefix_bytes_ = 0;
  if (slice.size() > kSmallMessageBytes) {
    const auto* const rpc = FindRpc(path_);
    if (rpc != nullptr &&
        !ReserveForMessage(ParsedSize(*rpc->input_type(), {slice.begin(), slice.size()}))) {
      return;
    }
  }
  queue_.push_back({grpc::ByteBuffer(&slice, 1), message_reserved_});
  BeginCall();
  WriteNext();
}

void CallStream::WriteNext() {
  if (writing_ || !holding_) return;
  if (read_ended_) {
    // gRPC 1.51 never frees an in-process call if the client's end was not closed.
    if (!std::exchange(writes_done_, true)) StartWritesDone();
    return ReleaseHold();
  }
  if (refused_ || writes_done_) return;
  if (!queue_.empty()) {
    writing_ = true;
    writes_done_ = !streams_;
    grpc::WriteOptions options;
    if (!streams_) options.set_last_message();
    StartWrite(&queue_.front().bytes, options);
  } else if (request_ended_ && !std::exchange(writes_done_, true)) {
    StartWritesDone();
  }
}

void CallStream::EndRequest() {
  request_ended_ = true;
  if (prefix_bytes_ > 0 && !refused_ && !ended_) {
    return Refuse(Refusal(grpc::StatusCode::INVALID_ARGUMENT,
                          "the request ended in the middle of a message"));
  }
  BeginCall();
  WriteNext();
}

void CallStream::OnWriteDone(bool /*ok*/) {
  host_->Post([self = shared_from_this()] {
    self->writing_ = false;
    self->Release(self->queue_.front().reserved);
    self->queue_.pop_front();
    if (self->queue_.size() < kMaxQueuedMessages) self->Credit(std::exchange(self->uncredited_, 0));
    self->WriteNext();
  });
}

void CallStream::Credit(std::size_t bytes) {
  if (bytes > 0 && !detached_) nghttp2_session_consume_stream(host_->session(), id_, bytes);
}

void CallStream::ReadNext() {
  if (reading_ || !holding_) return;
  reading_ = true;
  StartRead(&incoming_);
}

void CallStream::OnReadDone(bool ok) {
  host_->Post([self = shared_from_this(), ok] {
    self->reading_ = false;
    if (!ok || self->refused_ || self->detached_) return self->EndReading();
    self->Answer();
  });
}

void CallStream::EndReading() {
  read_ended_ = true;
  WriteNext();
}

// No operation may start after this; OnDone can follow.
void CallStream::ReleaseHold() {
  if (std::exchange(holding_, false)) RemoveHold();
}

void CallStream::Answer() {
  const auto bytes = static_cast<std::int64_t>(incoming_.Length());
  if (const absl::Status reserved = Reserve(bytes); !reserved.ok())
    return Refuse(ToGrpcStatus(reserved));
  answer_bytes_ = bytes;
  const MessagePrefix prefix = MakeMessagePrefix(static_cast<std::uint32_t>(bytes));
  answer_.emplace_back(prefix.data(), prefix.size());
  std::vector<grpc::Slice> slices;
  if (incoming_.Dump(&slices).ok()) {
    for (grpc::Slice& slice : slices) {
      if (slice.size() > 0) answer_.push_back(std::move(slice));
    }
  }
  incoming_.Clear();
  answer_latest_ = Clock::now() + bridge_.limits.options().idle_limit +
                   std::chrono::milliseconds(bytes / kMinBytesPerMillisecond);
  if (!std::exchange(responding_, true)) {
    Submit({{":status", "200"}, {"content-type", "application/grpc"}}, false);
  } else {
    nghttp2_session_resume_data(host_->session(), id_);
  }
}

ssize_t CallStream::Send(std::span<std::uint8_t> into, std::uint32_t& flags) {
  std::size_t sent = 0;
  while (sent < into.size() && !answer_.empty()) {
    const grpc::Slice& first = answer_.front();
    const std::size_t size = std::min(first.size() - answer_offset_, into.size() - sent);
    std::memcpy(into.data() + sent, first.begin() + answer_offset_, size);
    sent += size;
    answer_offset_ += size;
    if (answer_offset_ < first.size()) continue;
    answer_.pop_front();
    answer_offset_ = 0;
  }
  if (answer_.empty()) {
    Release(std::exchange(answer_bytes_, 0));
    answer_latest_ = Clock::time_point::max();
    if (ended_) {
      flags |= NGHTTP2_DATA_FLAG_EOF | NGHTTP2_DATA_FLAG_NO_END_STREAM;
      const std::vector<nghttp2_nv> views = Views(trailers_);
      nghttp2_submit_trailer(host_->session(), id_, views.data(), views.size());
    } else {
      ReadNext();
    }
  }
  return sent > 0 || ended_ ? static_cast<ssize_t>(sent) : ssize_t{NGHTTP2_ERR_DEFERRED};
}

void CallStream::OnDone(const grpc::Status& status) {
  host_->Post([self = shared_from_this(), status] {
    self->self_.reset();
    self->End(status);
  });
}

void CallStream::End(const grpc::Status& status) {
  if (std::exchange(ended_, true) || detached_) return;
  trailers_ = MakeTrailers(status);
  if (responding_) {
    nghttp2_session_resume_data(host_->session(), id_);
    return;
  }
  HeaderList headers = {{":status", "200"}, {"content-type", "application/grpc"}};
  headers.insert(headers.end(), trailers_.begin(), trailers_.end());
  Submit(headers, true);
}

void CallStream::Refuse(const grpc::Status& status) {
  if (std::exchange(refused_, true)) return;
  if (self_ == nullptr && !ended_) {
    return End(bridge_.Refuse(path_, status, PrintableAscii(request_id_), host_->peer()));
  }
  Cancel();
  answer_.clear();
  End(status);
}

void CallStream::RespondHttp(int code) {
  refused_ = ended_ = true;
  Submit({{":status", std::to_string(code)}}, true);
}

void CallStream::Submit(const HeaderList& headers, bool end) {
  const std::vector<nghttp2_nv> views = Views(headers);
  nghttp2_data_provider provider{{.ptr = this}, ReadAnswer};
  nghttp2_submit_response(host_->session(), id_, views.data(), views.size(),
                          end ? nullptr : &provider);
}

void CallStream::Detach() {
  if (std::exchange(detached_, true)) return;
  Cancel();
  answer_.clear();
  grpc_slice_unref(std::exchange(message_, grpc_empty_slice()));
  Release(memory_.bytes());
}

void CallStream::Cancel() {
  if (self_ == nullptr) return;
  context_.TryCancel();
  if (!reading_) EndReading();  // otherwise OnReadDone does it
}

void CallStream::Tick(Clock::time_point now) {
  if (now >= request_latest_) {
    request_latest_ = Clock::time_point::max();
    Refuse(Refusal(grpc::StatusCode::DEADLINE_EXCEEDED,
                   "idle timeout: the request did not arrive within --silence-limit"));
  }
  if (now < answer_latest_) return;
  nghttp2_submit_rst_stream(host_->session(), NGHTTP2_FLAG_NONE, id_, NGHTTP2_CANCEL);
}

// False: the call was refused.
bool CallStream::ReserveForMessage(std::int64_t bytes) {
  const absl::Status reserved = Reserve(bytes);
  if (!reserved.ok()) Refuse(ToGrpcStatus(reserved));
  message_reserved_ += bytes;
  return reserved.ok();
}

absl::Status CallStream::Reserve(std::int64_t more) {
  return memory_.Resize(memory_.bytes() + more);
}

void CallStream::Release(std::int64_t bytes) {
  memory_.Resize(std::max<std::int64_t>(0, memory_.bytes() - bytes)).IgnoreError();
}

}  // namespace motiondb::server
