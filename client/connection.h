// The connection of a client: its channels, their stubs, and how to make a call. The only header
// that includes the generated services.
//
// Each address has its own channel: gRPC 1.51 has no public resolver for several names. Its target
// `ipv4:A,B` takes only numbers, and compares the certificates of all servers with one name. So
// retries are made here, too: gRPC's retryPolicy does not leave its channel.
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

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/routing.h"

namespace motiondb::client {

// Maximum size of a file block in the wire contract.
inline constexpr size_t kBlockBytes = size_t{1} << 20;

// Stores the next block of a file in `block`; an empty block at the end.
using BlockReader = std::function<absl::Status(std::string& block)>;

// The files of an ingest call. `is_repeatable`: they can be opened and read again.
struct IngestSource {
  BlockReader file;
  BlockReader skeleton;
  bool is_repeatable = true;
};
using OpenIngestSource = std::function<absl::StatusOr<IngestSource>()>;

// Callbacks for the parts of an export, called in stream order.
struct ExportSink {
  std::function<absl::Status(const v1::ExportClipHeader&)> on_header;
  std::function<absl::Status(const std::string&)> on_file_block;
  std::function<absl::Status(const std::string&)> on_skeleton_block;
};

// The addresses in ClientOptions::server. INVALID_ARGUMENT: there is none, or one is empty.
absl::StatusOr<std::vector<std::string>> AddressesOf(const std::string& server);

// A server. Opens the channel without waiting for the connection.
struct Endpoint {
  // options.server: its address. options.credentials must be set. `has_others`: the client has
  // further addresses.
  Endpoint(const ClientOptions& options, bool has_others);

  const std::string address;
  const std::shared_ptr<grpc::Channel> channel;
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
template <typename Stub>
using StubMember = const std::unique_ptr<Stub> Endpoint::*;

// One attempt of a call, with its gRPC context. Used by one thread at a time.
struct OutgoingCall {
  explicit OutgoingCall(const Endpoint& its_endpoint) : endpoint(its_endpoint) {}

  const Endpoint& endpoint;
  grpc::ClientContext context;
  CallOptions options;
  std::string database;    // id, for kDatabaseKey; may be empty
  std::string request_id;  // of all attempts
  std::chrono::system_clock::time_point deadline = std::chrono::system_clock::time_point::max();
  std::string tried;  // addresses of this attempt and of earlier ones
  int attempt = 1;
  // False if the caller has received a part of the answer, or the input cannot be read again.
  bool is_repeatable = true;
  bool is_cancelled = false;  // by this client
};

// What a call does: a change may only be made once.
enum class Effect { kRead, kChange };

class Client::Connection {
 public:
  // `addresses` and options.credentials must be set.
  Connection(const ClientOptions& options, const std::vector<std::string>& addresses);

  // Waits until a channel is connected; earlier addresses are preferred. UNAVAILABLE after
  // options.connect_timeout.
  absl::Status WaitUntilConnected() const;

  int address_count() const { return static_cast<int>(endpoints_.size()); }

  // Begins the first attempt of a call to the server that answered last: sets its deadline, its
  // token, its request id and its database.
  std::unique_ptr<OutgoingCall> Begin(const CallOptions& options,
                                      const std::string& database) const;

  // Converts the result of a call. The error has the request id. UNAVAILABLE names the addresses
  // and makes the next call use the next address; DEADLINE_EXCEEDED names the timeout. CANCELLED
  // becomes UNAVAILABLE unless this client cancelled the call.
  absl::Status Finish(const grpc::Status& status, const OutgoingCall& call) const;

  // Makes a call with `attempt`, which takes an OutgoingCall and returns its absl::Status. After
  // UNAVAILABLE makes another attempt, at most one for each address, and two if there is only one
  // (a proxy), or more for 2 s while its server stops: of each read, and of changes that no server
  // has begun.
  template <typename Attempt>
  absl::Status Run(Effect effect, const CallOptions& options, const std::string& database,
                   const Attempt& attempt) const {
    auto call = Begin(options, database);
    while (true) {
      absl::Status status = attempt(*call);
      auto next = NextAttempt(effect, status, *call);
      if (next == nullptr) return status;
      call = std::move(next);
    }
  }

  // Makes a unary call.
  template <typename Stub, typename Request, typename Response>
  absl::StatusOr<Response> Call(Effect effect, StubMember<Stub> stub,
                                grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                             Response*),
                                const Request& request, const CallOptions& options) const {
    Response response;
    const absl::Status status = Run(effect, options, DatabaseOf(request), [&](OutgoingCall& call) {
      return Finish(((call.endpoint.*stub).get()->*method)(&call.context, request, &response),
                    call);
    });
    if (!status.ok()) return status;
    return response;
  }

  // Makes a server-streaming call, which is a read. `on_message` receives each message; if it
  // returns an error, the call is cancelled and the error returned.
  template <typename Stub, typename Request, typename Response>
  absl::Status ReadStream(StubMember<Stub> stub,
                          std::unique_ptr<grpc::ClientReader<Response>> (Stub::*method)(
                              grpc::ClientContext*, const Request&),
                          const Request& request,
                          const std::function<absl::Status(const Response&)>& on_message,
                          const CallOptions& options) const {
    return Run(Effect::kRead, options, DatabaseOf(request), [&](OutgoingCall& call) {
      const auto reader = ((call.endpoint.*stub).get()->*method)(&call.context, request);
      Response message;
      absl::Status consumed;
      while (consumed.ok() && reader->Read(&message)) {
        call.is_repeatable = false;
        consumed = on_message(message);
      }
      if (!consumed.ok()) call.context.TryCancel();
      const grpc::Status status = reader->Finish();
      return consumed.ok() ? Finish(status, call) : consumed;
    });
  }

  // Makes an ingest call: the header, then the blocks of both files. An attempt opens the files.
  absl::StatusOr<v1::IngestClipResponse> Ingest(const v1::IngestClipHeader& header,
                                                const OpenIngestSource& open,
                                                const CallOptions& options) const;
  // Makes an export call. DATA_LOSS: the stream does not have exactly one header, at its beginning.
  absl::Status Export(const v1::ExportClipRequest& request, const ExportSink& sink,
                      const CallOptions& options) const;

 private:
  absl::Status WaitForAny() const;
  absl::Status ConnectErrorOf(const Endpoint& endpoint) const;
  const Endpoint& current() const { return *endpoints_[current_]; }
  void Prepare(OutgoingCall& call) const;
  // Returns the next attempt of a call that ended with `status`; null if the call has ended.
  std::unique_ptr<OutgoingCall> NextAttempt(Effect effect, const absl::Status& status,
                                            const OutgoingCall& call) const;
  // Makes the following calls use the next address, unless another call has changed it already.
  void Leave(const Endpoint& endpoint) const;

  const ClientOptions options_;
  std::vector<std::unique_ptr<const Endpoint>> endpoints_;
  mutable std::atomic<std::size_t> current_ = 0;
};

}  // namespace motiondb::client
