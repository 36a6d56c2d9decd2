// One request of the Connect protocol, passed to the gRPC server of this process as a call. It
// converts the request to a protobuf message and the responses to JSON, compressed if wanted.
//
// Runs on the thread of its connection; gRPC's callbacks post there. Conversions of much data run
// on a thread of their own. It lives until both the connection and gRPC have released it.
#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/client_callback.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/engine/work/thread_pool.h"
#include "server/gateway/connect_request.h"
#include "server/http1/http_exchange.h"
#include "server/http2/call_bridge.h"

namespace motiondb::server {

class GatewayCall final : public HttpWork,
                          public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                          public std::enable_shared_from_this<GatewayCall> {
 public:
  // `bridge` and `converters` must outlive the call.
  GatewayCall(CallBridge& bridge, ThreadPool& converters, ConnectRequest request,
              std::shared_ptr<HttpExchange> exchange);

  std::optional<HttpResponse> Admit(std::int64_t body_bytes) override;
  void Start(std::string body) override;
  void OnSent() override;
  void Cancel() override;

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

  template <typename Result>
  void Convert(std::int64_t bytes, std::function<absl::StatusOr<Result>()> work,
               std::function<void(absl::StatusOr<Result>)> take);
  absl::StatusOr<std::string> Decode(std::string body);
  absl::StatusOr<std::string> DecodeMessage(std::string content, bool compressed);
  absl::StatusOr<std::string> Encode(const std::string& message);
  void BeginCall(std::string message);
  void TakeResponse();
  void SendMessage(std::string message);
  void ReadNext();
  void EndReading();
  void ReleaseHold();
  void Finish(const grpc::Status& status);
  void RespondMessage();
  grpc::Status Refusal(const absl::Status& fault) const;
  void Refuse(const absl::Status& fault);
  absl::Status CheckSize(std::int64_t bytes);
  absl::Status Reserve(std::int64_t bytes);
  std::int64_t max_body_bytes() const;

  CallBridge& bridge_;
  ThreadPool& converters_;
  const ConnectRequest request_;
  const std::shared_ptr<HttpExchange> exchange_;
  const std::chrono::system_clock::time_point began_ = std::chrono::system_clock::now();
  CallMemory::Reservation memory_;  // of bodies and messages in transit

  // State of the call. `self_` keeps this alive while gRPC uses it, until OnDone.
  grpc::ClientContext context_;
  std::shared_ptr<GatewayCall> self_;
  grpc::ByteBuffer outgoing_;
  grpc::ByteBuffer incoming_;
  bool begun_ = false;
  bool reading_ = false;
  bool writing_ = false;
  bool read_ended_ = false;
  bool holding_ = false;                // gRPC expects further operations; if false, none may start
  std::atomic<bool> detached_ = false;  // the client gets nothing more
  bool converting_ = false;             // another thread uses `memory_` and `too_large_`
  bool too_large_ = false;              // the request; otherwise an error is that of the memory
  std::optional<std::string> message_;  // of a unary response
  bool streaming_ = false;              // the head of a stream is sent
};

}  // namespace motiondb::server
