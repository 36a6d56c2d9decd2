// Unary calls: handlers run on a request thread, never on a thread of gRPC.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "core/motion/error.h"
#include "core/motion/execution.h"
#include "server/engine/engine.h"
#include "server/engine/query/query.h"
#include "server/engine/representation.h"
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

// Owned by gRPC: deletes itself when the call is over.
class UnaryReactor final : public grpc::ServerUnaryReactor {
 public:
  UnaryReactor(ServiceContext& host, const grpc::CallbackServerContext& context,
               const Method& method)
      : parking_(host.engine.workers()),
        entry_(host, context, method, [this] { parking_.Stop(); }) {}
  CallContext& entry() { return entry_; }
  Parking& parking() { return parking_; }
  void End(grpc::Status status, std::size_t answer_bytes = 0) {
    Finish(entry_.End(std::move(status), answer_bytes));
  }
  void OnCancel() override { parking_.Wake(); }
  void OnDone() override { delete this; }

 private:
  Parking parking_;
  CallContext entry_;
};

// Runs kHandler and ends the call with its result. If the work turns out to be heavy, the call is
// queued again as a heavy call. If it awaits a change, it runs again after the change.
template <auto kHandler, typename Request, typename Response>
void Work(ServiceContext& host, const Request& request, Response& response, UnaryReactor& reactor,
          grpc::Status checked) {
  if (!checked.ok()) return reactor.End(std::move(checked));
  CallContext& entry = reactor.entry();
  Parking& parking = reactor.parking();
  const Call call{host.engine,  entry.cancelled(), entry.deadline(), entry,
                  host.monitor, parking,           host.streams,     host.others.get()};
  const LogFields fields{{"request_id", entry.request_id()}};
  bool is_heavy = false;
  bool waits = false;
  std::size_t bytes = 0;
  parking.BeginStep();
  grpc::Status answered = RunHandler(call.cancelled, [&]() -> absl::Status {
    absl::Status handled = kHandler(call, request, response);
    is_heavy = IsHeavyWork(handled);
    waits = IsAwaitingChange(handled);
    if (!handled.ok()) return handled;
    bytes = response.ByteSizeLong();
    MOTIONDB_RETURN_IF_ERROR(entry.ReserveWork(0));
    return entry.ReserveResponse(response, bytes);
  });
  if (waits && parking.stopped()) return reactor.End(StoppingStatus());
  if (waits) {
    return parking.Park(call.deadline, [&host, &request, &response, &reactor] {
      reactor.entry().Post([&] {
        Work<kHandler>(host, request, response, reactor, ToGrpcStatus(reactor.entry().Recheck()));
      });
    });
  }
  if (!is_heavy) return reactor.End(std::move(answered), bytes);
  entry.BeginHeavy([&](grpc::Status entered) {
    Work<kHandler>(host, request, response, reactor, std::move(entered));
  });
}

// Answers a unary call with kHandler(call, request, response), run on a request thread. gRPC keeps
// context, request and response until the call is finished.
template <auto kHandler, typename Request, typename Response>
grpc::ServerUnaryReactor* Answer(ServiceContext& host, grpc::CallbackServerContext* context,
                                 const Request* request, Response* response) {
  auto* const reactor = new UnaryReactor(host, *context, MethodOf<Request>());
  if (grpc::Status admission = reactor->entry().Admission(); !admission.ok()) {
    reactor->End(std::move(admission));
    return reactor;
  }
  reactor->entry().SetRequestSize(request->ByteSizeLong());
  reactor->entry().Begin(*request, [&host, request, response, reactor](grpc::Status checked) {
    Work<kHandler>(host, *request, *response, *reactor, std::move(checked));
  });
  return reactor;
}

// Runs one step of a call and returns its status. Exceptions become RESOURCE_EXHAUSTED (out of
// memory) or INTERNAL. CANCELLED if the call is cancelled before the step, or while the step waits
// for a reader of the store.
grpc::Status RunHandler(const core::Cancelled& cancelled,
                        const std::function<absl::Status()>& handler);

}  // namespace motiondb::server
