// One HTTP/2 stream of a client, passed to the gRPC server of this process as a call. It receives
// headers and messages, passes them to gRPC, and queues the response for the connection.
//
// Runs only on the thread of its connection; gRPC's callbacks post there. It lives until both the
// connection and gRPC have released it.
#pragma once

#include <grpcpp/client_context.h>
#include <nghttp2/nghttp2.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/http2/call_bridge.h"
#include "server/http2/grpc_wire.h"
#include "server/rpc/call_limits.h"

namespace motiondb::server {

// The connection of a stream.
class StreamConnection {
 public:
  virtual ~StreamConnection() = default;
  // Only for streams that are not detached, on the connection's thread.
  virtual nghttp2_session* session() = 0;
  // Runs `work` on the connection's thread, then sends pending output. Callable from any thread.
  virtual void Post(std::function<void()> work) = 0;
  // Address of the client, "ipv4:127.0.0.1:50000", and the common name of its certificate, or "".
  virtual const std::string& peer() const = 0;
  virtual const std::string& common_name() const = 0;
  // True: no new call may begin, because gRPC is about to shut down.
  virtual bool draining() const = 0;
};

class CallStream final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                         public std::enable_shared_from_this<CallStream> {
 public:
  using Clock = std::chrono::steady_clock;

  // `exempt`: the call itself does not count for the memory budget, so that a client that shares an
  // address with others can always make a few calls. Headers and messages always count.
  CallStream(CallBridge& bridge, std::shared_ptr<StreamConnection> host, std::int32_t id,
             bool exempt);

  // False: the headers are far too large; close the connection.
  bool AddHeader(std::string_view name, std::string_view value);
  // Call after all input that arrived with the headers was processed: a call that was reset by then
  // does not begin.
  void Begin();
  void Receive(std::span<const std::uint8_t> data);
  // The client has half-closed the stream.
  void EndRequest();
  // Same contract as nghttp2_data_source_read_callback.
  ssize_t Send(std::span<std::uint8_t> into, std::uint32_t& flags);
  // The stream or its connection has ended: cancels the call and stops using the session.
  void Detach();
  // Ends the call if the client sends the request, or reads the response, too slowly.
  void Tick(Clock::time_point now);

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

  void Refuse(const grpc::Status& status);
  void RespondHttp(int code);
  void Submit(const HeaderList& headers, bool end);
  void End(const grpc::Status& status);
  void Answer();
  bool ReserveForMessage(std::int64_t bytes);
  absl::Status Reserve(std::int64_t more);
  void Release(std::int64_t bytes);
  void TakePrefix();
  void TakeMessage();
  void WriteNext();
  void ReadNext();
  void BeginCall();
  void EndReading();
  void ReleaseHold();
  void Cancel();
  void Credit(std::size_t bytes);

  CallBridge& bridge_;
  const std::shared_ptr<StreamConnection> host_;
  const std::int32_t id_;
  const bool exempt_;

  // Request headers.
  std::size_t header_bytes_ = 0;
  std::string method_, path_, content_type_, timeout_, encoding_, authorization_, request_id_;

  // Memory of headers and messages in transit.
  CallMemory::Reservation memory_;

  // State of the call. `self_` keeps the stream alive while gRPC uses it, until OnDone.
  grpc::ClientContext context_;
  std::shared_ptr<CallStream> self_;
  grpc::ByteBuffer incoming_;
  bool checked_ = false;                                         // the headers are valid
  bool streams_ = false;                                         // client streaming
  Clock::time_point request_latest_ = Clock::time_point::max();  // deadline for the one message
  bool reading_ = false;
  bool read_ended_ = false;
  bool holding_ = false;  // gRPC expects further operations; if false, none may start
  bool refused_ = false;  // the rest of the request is ignored
  bool detached_ = false;

  // The request: the message that is being received, and those queued for gRPC.
  MessagePrefix prefix_{};
  std::size_t prefix_bytes_ = 0;
  grpc_slice message_ = grpc_empty_slice();
  std::size_t message_bytes_ = 0;
  struct Message {
    grpc::ByteBuffer bytes;
    std::int64_t reserved = 0;
  };
  std::deque<Message> queue_;  // while `writing_`, gRPC reads the first
  std::int64_t message_reserved_ = 0;
  bool writing_ = false;
  bool request_ended_ = false;
  bool writes_done_ = false;
  std::size_t uncredited_ = 0;  // received bytes not yet returned to the flow-control window

  // The response.
  std::deque<grpc::Slice> answer_;
  std::size_t answer_offset_ = 0;  // in the first slice
  std::int64_t answer_bytes_ = 0;  // reserved for all slices
  Clock::time_point answer_latest_ = Clock::time_point::max();
  bool responding_ = false;  // response headers are submitted
  bool ended_ = false;       // trailers_ is valid
  HeaderList trailers_;
};

}  // namespace motiondb::server
