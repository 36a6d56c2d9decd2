// Unary calls: handlers run on a request thread, never on a thread of gRPC.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "core/motion/execution.h"
#include "server/engine/engine.h"
#include "server/engine/query/query.h"
#include "server/engine/work/work_options.h"
#include "server/observability/log.h"
#include "server/rpc/call_context.h"
#include "server/rpc/parking.h"
#include "server/translate/resource_name.h"
#include "server/translate/status_mapping.h"

namespace motiondb::server {

// Context of a handler, besides the request.
struct Call {
  Engine& engine;
  core::Cancelled cancelled;                       // deadline exceeded, or the client disconnected
  std::chrono::system_clock::time_point deadline;  // far in the future if the client set none
  CallContext& entry;                              // the caller and its limits
  Monitor& monitor;                                // statistics of the server
  Parking& parking;                                // how it waits for a change
  RunningStreams& streams;                         // of the server
  OtherServers* others;                            // null: the store is not shared

  WorkOptions work_options() const {
    return {entry.allowed(), cancelled,
            [&entry = entry](std::int64_t bytes) { return entry.ReserveWork(bytes); }, deadline,
            [&parking = parking](ChangeSignal& signal) { parking.WakeOn(signal); }};
  }
};

// Begins a query of the database, filter and revision of the request. Errors: INVALID_ARGUMENT, and
// those of Query::Begin.
template <typename Request>
absl::StatusOr<Query> BeginQuery(const Call& call, const Request& request) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string id,
                            ParseDatabaseName("database", request.database()));
  return Query::Begin(call.engine, id, call.work_options(),
                      {request.filter(), request.min_revision()});
}

// A unary call. Owned by gRPC: deletes itself when the call is over.
class UnaryReactor final : public grpc::ServerUnaryReactor {
 public:
  // Fills the response.
  using Handler = std::function<absl::Status(const Call&)>;

  // Runs `handler` on a request thread and ends the call with its result. If the work turns out to
  // be heavy, the call is queued again as a heavy call. If it awaits a change, it runs again after
  // the change. gRPC keeps `context`, `request` and `response` until the call is finished.
  UnaryReactor(ServiceContext& host, const grpc::CallbackServerContext& context,
               const Method& method, const google::protobuf::Message& request,
               const google::protobuf::Message& response, Handler handler);
  void OnCancel() override { parking_.Wake(); }
  void OnDone() override { delete this; }

 private:
  void Work(grpc::Status checked);
  void End(grpc::Status status, std::size_t answer_bytes = 0);

  Parking parking_;
  CallContext entry_;
  const Call call_;
  const google::protobuf::Message& response_;
  const Handler handler_;
};

// Answers a unary call with kHandler(call, request, response).
template <auto kHandler, typename Request, typename Response>
grpc::ServerUnaryReactor* Answer(ServiceContext& host, grpc::CallbackServerContext* context,
                                 const Request* request, Response* response) {
  return new UnaryReactor(
      host, *context, MethodOf<Request>(), *request, *response,
      [request, response](const Call& call) {
        response->Clear();  // of what a run before, which was too heavy or waits, has set
        return kHandler(call, *request, *response);
      });
}

// Runs one step of a call and returns its status. Exceptions become RESOURCE_EXHAUSTED (out of
// memory) or INTERNAL. CANCELLED if the call is cancelled before the step, or while the step waits
// for a reader of the store.
grpc::Status RunHandler(const core::Cancelled& cancelled,
                        const std::function<absl::Status()>& handler);

}  // namespace motiondb::server
