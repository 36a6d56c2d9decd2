// The connection of a client: its channel, its stubs, and how to make a call. The only header that
// includes the generated services.
#pragma once

#include <grpcpp/grpcpp.h>
#include <motiondb/client.h>
#include <motiondb/v1/access.grpc.pb.h>
#include <motiondb/v1/clip.grpc.pb.h>
#include <motiondb/v1/database.grpc.pb.h>
#include <motiondb/v1/edit.grpc.pb.h>
#include <motiondb/v1/marker_set.grpc.pb.h>
#include <motiondb/v1/model.grpc.pb.h>
#include <motiondb/v1/observe.grpc.pb.h>
#include <motiondb/v1/operation.grpc.pb.h>
#include <motiondb/v1/query.grpc.pb.h>
#include <motiondb/v1/segment.grpc.pb.h>
#include <motiondb/v1/server.grpc.pb.h>
#include <motiondb/v1/store.grpc.pb.h>
#include <motiondb/v1/view.grpc.pb.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace motiondb::client {

// Maximum size of a file block in the wire contract.
inline constexpr size_t kBlockBytes = size_t{1} << 20;

// Stores the next block of a file in `block`; an empty block at the end.
using BlockReader = std::function<absl::Status(std::string& block)>;

// Callbacks for the parts of an export, called in stream order.
struct ExportSink {
  std::function<absl::Status(const v1::ExportClipHeader&)> on_header;
  std::function<absl::Status(const std::string&)> on_file_block;
  std::function<absl::Status(const std::string&)> on_skeleton_block;
};

// An outgoing call: its gRPC context, options and request id. Used by one thread at a time.
struct OutgoingCall {
  explicit OutgoingCall(const CallOptions& its_options);

  grpc::ClientContext context;
  const CallOptions options;
  const std::string request_id;
  bool is_cancelled = false;  // by this client
};

class Client::Connection {
 public:
  // Opens the channel without waiting for the connection. options.credentials must be set.
  explicit Connection(ClientOptions options);

  // Waits until the channel is connected. UNAVAILABLE after options.connect_timeout.
  absl::Status WaitUntilConnected() const;

  // Returns the timeout of a call, or the default.
  std::chrono::milliseconds TimeoutOf(const CallOptions& options) const;

  // Sets the deadline of a call, its token and its request id.
  void Prepare(OutgoingCall& call) const;

  // Converts the result of a call. The error has the request id, and names the address if it is
  // UNAVAILABLE or the timeout if it is DEADLINE_EXCEEDED. CANCELLED becomes UNAVAILABLE unless
  // this client cancelled the call.
  absl::Status Finish(const grpc::Status& status, const OutgoingCall& call) const;

  // Makes a unary call.
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

  // Makes a server-streaming call. `on_message` receives each message; if it returns an error, the
  // call is cancelled and the error returned.
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

  // Makes an ingest call: the header, then the blocks of both files.
  absl::StatusOr<v1::IngestClipResponse> Ingest(const v1::IngestClipHeader& header,
                                                const BlockReader& file,
                                                const BlockReader& skeleton,
                                                const CallOptions& options) const;
  // Makes an export call. DATA_LOSS: the stream does not have exactly one header, at its beginning.
  absl::Status Export(const v1::ExportClipRequest& request, const ExportSink& sink,
                      const CallOptions& options) const;

 private:
  ClientOptions options_;
  std::shared_ptr<grpc::Channel> channel_;

 public:
  const std::unique_ptr<v1::DatabaseService::Stub> databases;
  const std::unique_ptr<v1::MarkerSetService::Stub> marker_sets;
  const std::unique_ptr<v1::ClipService::Stub> clips;
  const std::unique_ptr<v1::SegmentService::Stub> segments;
  const std::unique_ptr<v1::EditService::Stub> edits;
  const std::unique_ptr<v1::ModelService::Stub> models;
  const std::unique_ptr<v1::ViewService::Stub> views;
  const std::unique_ptr<v1::QueryService::Stub> queries;
  const std::unique_ptr<v1::ObserveService::Stub> observations;
  const std::unique_ptr<v1::OperationService::Stub> operations;
  const std::unique_ptr<v1::AccessService::Stub> access;
  const std::unique_ptr<v1::StoreService::Stub> store;
  const std::unique_ptr<v1::ServerService::Stub> server;
};

}  // namespace motiondb::client
