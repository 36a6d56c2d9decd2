// A client's connection: its channel, its stubs, and how one call is made on it. The only header
// that sees the generated services; everything in it may be used from any number of threads at
// once.
#pragma once

#include <grpcpp/grpcpp.h>
#include <motiondb/client.h>
#include <motiondb/v1/access.grpc.pb.h>
#include <motiondb/v1/clip.grpc.pb.h>
#include <motiondb/v1/database.grpc.pb.h>
#include <motiondb/v1/model.grpc.pb.h>
#include <motiondb/v1/observe.grpc.pb.h>
#include <motiondb/v1/operation.grpc.pb.h>
#include <motiondb/v1/query.grpc.pb.h>
#include <motiondb/v1/server.grpc.pb.h>
#include <motiondb/v1/store.grpc.pb.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace motiondb::client {

// The largest block of a file that the contract allows.
inline constexpr size_t kBlockBytes = size_t{1} << 20;

// Puts the next block of a file into `block`; nothing at the end.
using BlockReader = std::function<absl::Status(std::string& block)>;

// Who takes the parts of an export, in the order in which they come.
struct ExportSink {
  std::function<absl::Status(const v1::ExportClipHeader&)> on_header;
  std::function<absl::Status(const std::string&)> on_file_block;
  std::function<absl::Status(const std::string&)> on_skeleton_block;
};

// A call that is made: gRPC's side of it, how long it may take, and under which id the server's log
// has it. Used by one thread at a time.
struct OutgoingCall {
  explicit OutgoingCall(const CallOptions& its_options);

  grpc::ClientContext context;
  const CallOptions options;
  const std::string request_id;
  bool is_cancelled = false;  // by us
};

class Client::Connection {
 public:
  // Opens the channel, without waiting for it to connect. The options have their credentials.
  explicit Connection(ClientOptions options);

  // Waits until the server answers. UNAVAILABLE after options.connect_timeout.
  absl::Status WaitUntilConnected() const;

  // How long a call may take.
  std::chrono::milliseconds TimeoutOf(const CallOptions& options) const;

  // Sets a call's deadline, and says who calls and under which id.
  void Prepare(OutgoingCall& call) const;

  // How a call ended: UNAVAILABLE where it was broken off, and not by us; with its id, the address
  // where the server was not reached and the time where it was too short.
  absl::Status Finish(const grpc::Status& status, const OutgoingCall& call) const;

  // One unary call.
  template <typename Stub, typename Request, typename Response>
  absl::StatusOr<Response> Call(Stub& stub,
                                grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                             Response*),
                                const Request& request, const CallOptions& options) const {
    OutgoingCall call(options);
    Prepare(call);
    Response response;
    const absl::Status status = Finish((stub.*method)(&call.context, request, &response), call);
    if (!status.ok()) return status;
    return response;
  }

  // One call answered by a stream: `on_message` sees each message, and an error from it cancels the
  // call.
  template <typename Stub, typename Request, typename Response>
  absl::Status ReadStream(Stub& stub,
                          std::unique_ptr<grpc::ClientReader<Response>> (Stub::*method)(
                              grpc::ClientContext*, const Request&),
                          const Request& request,
                          const std::function<absl::Status(const Response&)>& on_message,
                          const CallOptions& options) const {
    OutgoingCall call(options);
    Prepare(call);
    const auto reader = (stub.*method)(&call.context, request);
    Response message;
    absl::Status consumed;
    while (consumed.ok() && reader->Read(&message)) consumed = on_message(message);
    if (!consumed.ok()) call.context.TryCancel();
    const grpc::Status status = reader->Finish();
    return consumed.ok() ? Finish(status, call) : consumed;
  }

  // One ingest: the header, then the blocks of both files.
  absl::StatusOr<v1::IngestClipResponse> Ingest(const v1::IngestClipHeader& header,
                                                const BlockReader& file,
                                                const BlockReader& skeleton,
                                                const CallOptions& options) const;
  // One export: DATA_LOSS unless a header comes first, and once.
  absl::Status Export(const v1::ExportClipRequest& request, const ExportSink& sink,
                      const CallOptions& options) const;

 private:
  ClientOptions options_;
  std::shared_ptr<grpc::Channel> channel_;

 public:
  const std::unique_ptr<v1::DatabaseService::Stub> databases;
  const std::unique_ptr<v1::ClipService::Stub> clips;
  const std::unique_ptr<v1::ModelService::Stub> models;
  const std::unique_ptr<v1::QueryService::Stub> queries;
  const std::unique_ptr<v1::ObserveService::Stub> observations;
  const std::unique_ptr<v1::OperationService::Stub> operations;
  const std::unique_ptr<v1::AccessService::Stub> access;
  const std::unique_ptr<v1::StoreService::Stub> store;
  const std::unique_ptr<v1::ServerService::Stub> server;
};

}  // namespace motiondb::client
