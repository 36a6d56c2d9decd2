#include "server/gateway/gateway_call.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <exception>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/work/memory_reserve.h"
#include "server/gateway/connect_json.h"
#include "server/gateway/connect_request.h"
#include "server/gateway/http_content.h"
#include "server/http2/grpc_wire.h"
#include "server/rpc/call_context.h"
#include "server/rpc/call_identity.h"
#include "server/security/attempt_limit.h"
#include "server/security/authorize.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {
namespace {

// Memory that gRPC and this class need for a call, besides its messages.
constexpr std::int64_t kGatewayCallBytes = 32 << 10;
// The most that one byte of deflate can become.
constexpr std::int64_t kMaxGzipRatio = 1032;
// Conversions of more bytes do not run on the connection's thread.
constexpr std::int64_t kSmallConversionBytes = 16 << 10;
// Memory while JSON is converted, as a multiple of its size: the text, the message, its parts.
constexpr std::int64_t kJsonFactor = 4;
// Memory of a response, as a multiple: gRPC's bytes, the message, the output.
constexpr std::int64_t kResponseFactor = 3;
constexpr std::int64_t kResponseJsonFactor = 5;
constexpr std::size_t kMinGzipBytes = 1 << 10;
// Base64 of the largest message, and some text around it.
constexpr std::int64_t kJsonExtraBytes = 64 << 10;
constexpr std::size_t kUnboundedParse = 4 << 10;  // the parsed size of smaller messages is ignored

// Runs a conversion; exceptions become a status.
template <typename Result>
absl::StatusOr<Result> WithoutExceptions(const std::function<absl::StatusOr<Result>()>& work) {
  try {
    const AllocationsMayFail scope;
    return work();
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        "out of memory for this request: send less, or retry later");
  } catch (const std::exception& error) {
    return absl::InternalError(error.what());
  }
}

std::string StringOf(const grpc::ByteBuffer& buffer) {
  std::string bytes;
  std::vector<grpc::Slice> slices;
  if (!buffer.Dump(&slices).ok()) return bytes;
  bytes.reserve(buffer.Length());
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return bytes;
}

// Returns a slice that owns the bytes.
grpc::Slice SliceOf(std::string bytes) {
  auto* const owned = new std::string(std::move(bytes));
  return {owned->data(), owned->size(), [](void* text) { delete static_cast<std::string*>(text); },
          owned};
}

}  // namespace

GatewayCall::GatewayCall(CallBridge& bridge, ThreadPool& converters, ConnectRequest request,
                         std::shared_ptr<HttpExchange> exchange)
    : bridge_(bridge),
      converters_(converters),
      request_(std::move(request)),
      exchange_(std::move(exchange)),
      memory_(bridge.memory, AttemptSource(AddressOf(exchange_->peer()))) {}

std::int64_t GatewayCall::max_body_bytes() const {
  const std::int64_t message = bridge_.max_message_bytes;
  return request_.is_json ? message / 3 * 4 + kJsonExtraBytes : message;
}

absl::Status GatewayCall::CheckSize(std::int64_t bytes) {
  const std::int64_t max = max_body_bytes();
  too_large_ = bytes > max;
  if (!too_large_) return absl::OkStatus();
  return absl::ResourceExhaustedError(fmt::format(
      "expected a request of at most {} bytes (--max-message-mib), got {} or more", max, bytes));
}

absl::Status GatewayCall::Reserve(std::int64_t bytes) {
  return memory_.Resize(kGatewayCallBytes + bytes);
}

std::optional<HttpResponse> GatewayCall::Admit(std::int64_t body_bytes) {
  const auto extra = static_cast<std::int64_t>(request_.streams ? kMessagePrefixBytes : 0);
  if (const absl::Status size = CheckSize(body_bytes - extra); !size.ok()) {
    return ErrorResponse(request_, Refusal(size), 413);
  }
  // The memory of compressed bodies also bounds how many of a client wait for a converter.
  const std::int64_t expanded =
      request_.sends_gzip ? std::min(max_body_bytes(), kMaxGzipRatio * body_bytes) : 0;
  if (const absl::Status reserved = Reserve(body_bytes + expanded); !reserved.ok()) {
    return ErrorResponse(request_, Refusal(reserved));
  }
  return std::nullopt;
}

// Runs `work`, on another thread if it has many bytes, and passes its result to `take` on the
// connection's thread.
template <typename Result>
void GatewayCall::Convert(std::int64_t bytes, std::function<absl::StatusOr<Result>()> work,
                          std::function<void(absl::StatusOr<Result>)> take) {
  if (bytes <= kSmallConversionBytes) return take(WithoutExceptions<Result>(work));
  converting_ = true;
  boost::asio::post(converters_.executor(), [self = shared_from_this(), work = std::move(work),
                                             take = std::move(take)]() mutable {
    // Cancelled if its client has disconnected meanwhile.
    auto result = self->detached_ ? absl::StatusOr<Result>(absl::CancelledError("disconnected"))
                                  : WithoutExceptions<Result>(work);
    self->exchange_->Post([self, result = std::move(result), take = std::move(take)]() mutable {
      self->converting_ = false;
      take(std::move(result));
    });
  });
}

void GatewayCall::Start(std::string body) {
  // Compressed bytes may become many.
  const bool is_small = static_cast<std::int64_t>(body.size()) <= kSmallConversionBytes;
  const std::int64_t bytes = is_small && !request_.sends_gzip ? 0 : kSmallConversionBytes + 1;
  // Shared, because a std::function is copied.
  const auto shared = std::make_shared<std::string>(std::move(body));
  Convert<std::string>(
      bytes, [this, shared] { return Decode(std::move(*shared)); },
      [self = shared_from_this()](absl::StatusOr<std::string> message) {
        if (self->detached_) return;
        if (!message.ok()) return self->Refuse(message.status());
        self->BeginCall(*std::move(message));
      });
}

absl::StatusOr<std::string> GatewayCall::Decode(std::string body) {
  // An empty body is never compressed.
  if (!request_.streams) {
    const bool compressed = request_.sends_gzip && !body.empty();
    return DecodeMessage(std::move(body), compressed);
  }
  MOTIONDB_ASSIGN_OR_RETURN(const Envelope envelope, ParseEnvelope(body));
  if (envelope.compressed && !request_.sends_gzip) {
    return core::InvalidArgument(
        "the envelope is compressed without connect-content-encoding: expected gzip");
  }
  body.erase(0, kMessagePrefixBytes);
  const bool compressed = envelope.compressed && !body.empty();
  return DecodeMessage(std::move(body), compressed);
}

// Returns the request as protobuf bytes. Reserves memory for all steps.
absl::StatusOr<std::string> GatewayCall::DecodeMessage(std::string content, bool compressed) {
  if (compressed) {
    const auto received = static_cast<std::int64_t>(content.size());
    const auto admit = [&](std::int64_t bytes) {
      const absl::Status size = CheckSize(bytes);
      return size.ok() ? Reserve(received + 2 * bytes) : size;
    };
    MOTIONDB_ASSIGN_OR_RETURN(content, Gunzip(content, admit));
  }
  const auto size = static_cast<std::int64_t>(content.size());
  const google::protobuf::Descriptor& type = *request_.method->input_type();
  if (request_.is_json) {
    MOTIONDB_RETURN_IF_ERROR(Reserve(kJsonFactor * size));
    MOTIONDB_ASSIGN_OR_RETURN(content, ProtoFromJson(type, content));
  }
  too_large_ = content.size() > bridge_.max_message_bytes;
  if (too_large_) {
    return absl::ResourceExhaustedError(
        fmt::format("expected a message of at most {} bytes (--max-message-mib), got {} bytes",
                    bridge_.max_message_bytes, content.size()));
  }
  std::int64_t parsed = 0;
  if (content.size() > kUnboundedParse) {
    const auto* const data = reinterpret_cast<const std::uint8_t*>(content.data());
    parsed = ParsedSize(type, {data, content.size()});
  }
  MOTIONDB_RETURN_IF_ERROR(Reserve(static_cast<std::int64_t>(content.size()) + parsed));
  // gRPC answers UNIMPLEMENTED to bytes that it cannot parse.
  if (!request_.is_json) MOTIONDB_RETURN_IF_ERROR(CheckProto(type, content));
  return content;
}

// As in CallStream: gRPC 1.51 crashes if an in-process call begins after the server was shut down,
// never frees a call whose message does not arrive, and aborts on metadata with other characters
// than printable ASCII. Clients cannot set metadata: only these fields are passed.
void GatewayCall::BeginCall(std::string message) {
  if (exchange_->draining()) return Finish(Refusal(ServerStopping()));
  if (request_.timeout.has_value()) {
    if (request_.timeout->count() == 0) {  // sent by clients whose deadline has passed
      return Finish(Refusal(core::WithReason(
          "CLIENT_DEADLINE", absl::DeadlineExceededError("connect-timeout-ms is 0"))));
    }
    context_.set_deadline(began_ + *request_.timeout);
  }
  context_.AddMetadata(kPeerMetadata, exchange_->peer());
  if (!exchange_->common_name().empty()) {
    context_.AddMetadata(kCommonNameMetadata, exchange_->common_name());
  }
  if (!request_.authorization.empty()) {
    context_.AddMetadata("authorization", request_.authorization);
  }
  if (!request_.request_id.empty()) context_.AddMetadata("x-request-id", request_.request_id);
  const grpc::Slice slice = SliceOf(std::move(message));
  outgoing_ = grpc::ByteBuffer(&slice, 1);
  self_ = shared_from_this();
  begun_ = true;
  bridge_.calls.PrepareBidiStreamingCall(&context_, request_.path(), {}, this);
  AddHold();
  holding_ = reading_ = writing_ = true;
  StartRead(&incoming_);
  grpc::WriteOptions options;
  options.set_last_message();
  StartWrite(&outgoing_, options);
  StartCall();
}

void GatewayCall::OnWriteDone(bool /*ok*/) {
  exchange_->Post([self = shared_from_this()] {
    self->writing_ = false;
    self->outgoing_.Clear();
    if (self->read_ended_) self->ReleaseHold();
  });
}

void GatewayCall::OnReadDone(bool ok) {
  exchange_->Post([self = shared_from_this(), ok] {
    self->reading_ = false;
    if (!ok || self->detached_) return self->EndReading();
    self->TakeResponse();
  });
}

void GatewayCall::TakeResponse() {
  const auto bytes = static_cast<std::int64_t>(incoming_.Length());
  const std::int64_t factor = request_.is_json ? kResponseJsonFactor : kResponseFactor;
  if (const absl::Status reserved = Reserve(factor * bytes); !reserved.ok()) {
    Refuse(reserved);
    return;
  }
  std::string message = StringOf(incoming_);
  incoming_.Clear();
  if (request_.streams) return SendMessage(std::move(message));
  message_ = std::move(message);
  ReadNext();
}

// Sends a message of a stream. The next one is read when the socket has accepted this one.
void GatewayCall::SendMessage(std::string message) {
  if (!std::exchange(streaming_, true)) exchange_->BeginStream(StreamHead(request_));
  const auto bytes = static_cast<std::int64_t>(message.size());
  Convert<std::string>(
      bytes,
      [this, message = std::move(message)]() -> absl::StatusOr<std::string> {
        MOTIONDB_ASSIGN_OR_RETURN(const std::string content, Encode(message));
        if (!request_.accepts_gzip || content.size() < kMinGzipBytes) {
          return MakeEnvelope(0, content);
        }
        return MakeEnvelope(kCompressed, Gzip(content));
      },
      [self = shared_from_this()](absl::StatusOr<std::string> envelope) {
        if (self->detached_) return self->EndReading();
        if (!envelope.ok()) return self->Refuse(envelope.status());
        self->exchange_->SendPart(*std::move(envelope));
      });
}

absl::StatusOr<std::string> GatewayCall::Encode(const std::string& message) {
  if (!request_.is_json) return message;
  return JsonFromProto(*request_.method->output_type(), message);
}

void GatewayCall::OnSent() {
  if (!detached_) ReadNext();
}

void GatewayCall::ReadNext() {
  if (reading_ || !holding_) return;
  reading_ = true;
  StartRead(&incoming_);
}

void GatewayCall::EndReading() {
  read_ended_ = true;
  if (!writing_) ReleaseHold();
}

// No operation may start after this; OnDone can follow.
void GatewayCall::ReleaseHold() {
  if (std::exchange(holding_, false)) RemoveHold();
}

void GatewayCall::OnDone(const grpc::Status& status) {
  exchange_->Post([self = shared_from_this(), status] {
    self->self_.reset();
    if (!self->detached_) self->Finish(status);
  });
}

void GatewayCall::Finish(const grpc::Status& status) {
  if (!request_.streams && status.ok() && message_.has_value()) return RespondMessage();
  detached_ = true;
  if (!streaming_) {
    // A stream without messages has the same response as a failed one.
    return exchange_->Respond(ErrorResponse(request_, status));
  }
  exchange_->SendPart(MakeEnvelope(kEndOfStream, EndOfStreamJson(status)));
  exchange_->EndStream();
}

void GatewayCall::RespondMessage() {
  const auto bytes = static_cast<std::int64_t>(message_->size());
  Convert<HttpResponse>(
      bytes,
      [this]() -> absl::StatusOr<HttpResponse> {
        MOTIONDB_ASSIGN_OR_RETURN(std::string body, Encode(*message_));
        HttpResponse response{.fields = {{"content-type", request_.content_type()},
                                         {"x-content-type-options", "nosniff"}},
                              .body = std::move(body)};
        if (request_.accepts_gzip && response.body.size() >= kMinGzipBytes) {
          response.body = Gzip(response.body);
          response.fields.emplace_back("content-encoding", "gzip");
        }
        return response;
      },
      [self = shared_from_this()](absl::StatusOr<HttpResponse> response) {
        if (self->detached_) return;
        if (!response.ok()) return self->Refuse(response.status());
        self->detached_ = true;
        self->exchange_->Respond(*std::move(response));
      });
}

// Returns the error of a request that does not become a call.
grpc::Status GatewayCall::Refusal(const absl::Status& fault) const {
  return bridge_.Refuse(request_.path(), ToGrpcStatus(fault), request_.request_id,
                        exchange_->peer());
}

// Ends the request with an error that did not come from the call.
void GatewayCall::Refuse(const absl::Status& fault) {
  const grpc::Status status = begun_ ? ToGrpcStatus(fault) : Refusal(fault);
  if (self_ != nullptr) context_.TryCancel();
  if (too_large_) {
    detached_ = true;
    exchange_->Respond(ErrorResponse(request_, status, 413));
  } else {
    message_.reset();
    Finish(status);
  }
  if (holding_ && !reading_) EndReading();
}

void GatewayCall::Cancel() {
  if (detached_.exchange(true)) return;
  if (!converting_) memory_.Resize(0).IgnoreError();  // a smaller amount is never refused
  if (self_ == nullptr) return;
  context_.TryCancel();
  if (!reading_ && !converting_) EndReading();  // otherwise it follows
}

}  // namespace motiondb::server
