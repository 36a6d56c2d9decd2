// One HTTP/2 stream of a client, as a call of the server in this process: takes its headers and
// messages, hands them to gRPC, and has the answer ready for the connection to send.
//
// Used on the thread of its connection alone; gRPC's callbacks post there. It lives until both the
// connection and gRPC have let go of it.
#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
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

#include "server/http2/grpc_wire.h"
#include "server/rpc/call_limits.h"
#include "server/rpc/call_memory.h"

namespace motiondb::server {

// What streams work with. Outlives them.
struct CallBridge {
  CallBridge(grpc::GenericStub stub, std::int64_t memory_bytes, const CallLimits& call_limits,
             std::uint32_t most_message_bytes)
      : calls(std::move(stub)),
        memory(memory_bytes),
        limits(call_limits),
        max_message_bytes(most_message_bytes) {}

  grpc::GenericStub calls;  // of the server in this process
  CallMemory memory;        // of calls on their way in and out, apart from the work on them
  const CallLimits& limits;
  const std::uint32_t max_message_bytes;
};

// The connection of a stream.
class StreamHost {
 public:
  virtual ~StreamHost() = default;
  // For streams that are not detached, on the connection's thread.
  virtual nghttp2_session* session() = 0;
  // Runs `work` on the connection's thread, and then sends what there is to send; safe to call from
  // any thread.
  virtual void Post(std::function<void()> work) = 0;
  // Of the client: "ipv4:127.0.0.1:50000", and the common name of its certificate or nothing.
  virtual const std::string& peer() const = 0;
  virtual const std::string& common_name() const = 0;
  // No call begins any more: gRPC is about to be shut down.
  virtual bool draining() const = 0;
};

class CallStream final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                         public std::enable_shared_from_this<CallStream> {
 public:
  using Clock = std::chrono::steady_clock;

  // `exempt`: the call itself costs no memory of the budget, so that a client that shares an
  // address with others always has a few calls. Headers and messages always do.
  CallStream(CallBridge& bridge, std::shared_ptr<StreamHost> host, std::int32_t id, bool exempt);

  // False: the headers are far too large, and the connection is to end.
  bool AddHeader(std::string_view name, std::string_view value);
  // The headers are complete, and what came with them is taken: a call that was reset meanwhile is
  // never begun.
  void Begin();
  void Receive(std::span<const std::uint8_t> data);
  // The client has sent all.
  void EndRequest();
  // As nghttp2_data_source_read_callback.
  ssize_t Send(std::span<std::uint8_t> into, std::uint32_t& flags);
  // The stream or its connection is over: cancels the call, and uses the session no more.
  void Detach();
  // Ends a call whose client takes the answer too slowly.
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
  void LetGo();
  void Cancel();
  void Credit(std::size_t bytes);

  CallBridge& bridge_;
  const std::shared_ptr<StreamHost> host_;
  const std::int32_t id_;
  const bool exempt_;

  // The request's headers.
  std::size_t header_bytes_ = 0;
  std::string method_, path_, content_type_, timeout_, encoding_, authorization_, request_id_;

  // Memory of messages on their way in and out.
  CallMemory::Reservation memory_;

  // The call. gRPC uses it from Begin to OnDone, which keeps the stream alive meanwhile.
  grpc::ClientContext context_;
  std::shared_ptr<CallStream> self_;
  grpc::ByteBuffer incoming_;
  bool checked_ = false;                                         // the headers are in order
  bool streams_ = false;                                         // the request has many messages
  Clock::time_point request_latest_ = Clock::time_point::max();  // for its one message
  bool reading_ = false;
  bool read_ended_ = false;
  bool holding_ = false;  // gRPC waits for further operations: without, none may be started
  bool refused_ = false;  // nothing of the request is looked at any more
  bool detached_ = false;

  // The request: the message that comes in, and those that gRPC has yet to take.
  MessagePrefix prefix_{};
  std::size_t prefix_bytes_ = 0;
  grpc_slice message_ = grpc_empty_slice();
  std::size_t message_bytes_ = 0;
  struct Message {
    grpc::ByteBuffer bytes;
    std::int64_t reserved = 0;
  };
  std::deque<Message> queue_;  // the first is being written while `writing_`
  std::int64_t message_reserved_ = 0;
  bool writing_ = false;
  bool request_ended_ = false;
  bool writes_done_ = false;
  std::size_t uncredited_ = 0;  // bytes for which the client has no new window yet

  // The answer.
  std::deque<grpc::Slice> answer_;
  std::size_t answer_offset_ = 0;  // in the first
  std::int64_t answer_bytes_ = 0;  // held for all of them
  Clock::time_point answer_latest_ = Clock::time_point::max();
  bool responding_ = false;  // the headers of the response are submitted
  bool ended_ = false;       // with trailers_
  HeaderList trailers_;
};

}  // namespace motiondb::server
