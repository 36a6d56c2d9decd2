// The services of motiondb.v1. Each translates between messages and the engine, and no more; each
// is owned by the caller and must outlive the grpc::Server that it is registered with, as the
// engine must outlive it.
#pragma once

#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/server_callback.h>

#include <memory>

#include "server/rpc/call.h"
#include "server/rpc/call_host.h"

namespace motiondb::v1 {
class IngestClipRequest;
class IngestClipResponse;
class RestoreStoreRequest;
class RestoreStoreResponse;
class ObserveRequest;
class ObserveResponse;
class WaitOperationRequest;
class WaitOperationResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

std::unique_ptr<grpc::Service> MakeDatabaseService(CallHost& host);
std::unique_ptr<grpc::Service> MakeClipService(CallHost& host);
std::unique_ptr<grpc::Service> MakeModelService(CallHost& host);
std::unique_ptr<grpc::Service> MakeOperationService(CallHost& host);
std::unique_ptr<grpc::Service> MakeQueryService(CallHost& host);
std::unique_ptr<grpc::Service> MakeObserveService(CallHost& host);
std::unique_ptr<grpc::Service> MakeAccessService(CallHost& host);
std::unique_ptr<grpc::Service> MakeStoreService(CallHost& host);
std::unique_ptr<grpc::Service> MakeServerService(CallHost& host);

// The calls that are answered by a reactor of their own: IngestClip and RestoreStore, which take a
// file in blocks; Observe; and WaitOperation, which waits without holding a thread. Each reactor is
// owned by gRPC: it deletes itself when the call is over.

grpc::ServerReadReactor<v1::IngestClipRequest>* NewIngestReactor(
    CallHost& host, grpc::CallbackServerContext& context, v1::IngestClipResponse& response);

grpc::ServerReadReactor<v1::RestoreStoreRequest>* NewRestoreReactor(
    CallHost& host, grpc::CallbackServerContext& context, v1::RestoreStoreResponse& response);

grpc::ServerBidiReactor<v1::ObserveRequest, v1::ObserveResponse>* NewObserveReactor(
    CallHost& host, grpc::CallbackServerContext& context);

grpc::ServerUnaryReactor* NewWaitReactor(CallHost& host, grpc::CallbackServerContext& context,
                                         const v1::WaitOperationRequest& request,
                                         v1::WaitOperationResponse& response);

}  // namespace motiondb::server
